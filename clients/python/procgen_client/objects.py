"""The objects of environments as arrays: the agent, the goals, and all other entities."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from procgen_client import _library
from procgen_client.catalog import catalog
from procgen_client.errors import InvalidArgumentError

# The numbers of an object, by their index in the last axis of Objects.values.
COLUMNS = _library.OBJECT_FIELDS
OBJECTS_MAX = 4096


class Objects(NamedTuple):
    """The objects of N environments, K rows each.

    In each environment the agent is row 0. The goals follow: what the agent has to reach, such as
    the coin of coinrun, whether it is an entity or a cell. All other entities come last, in a fixed
    order. Rows without an object have kind -1 and else zeros.

    Numbers are in cells from the bottom left of the level, y upwards, and velocities in cells per
    step. Each column of `values` is also an attribute: ``objects.x`` is a view, float32 [N, K].

    Attributes:
        values: float32 [N, K, 10], with the columns COLUMNS: kind (a number of the catalog's
            kinds), theme (index of its image, such as the color of a key), x, y (center), vx, vy,
            rx, ry (half-sizes), rotation (radians, clockwise), health (1 where unused).
        counts: int32 [N], the number of objects, which can exceed K.
        games: The game of each environment.
    """

    values: np.ndarray
    counts: np.ndarray
    games: tuple[str, ...]

    @property
    def kind(self) -> np.ndarray:
        """Numbers of kinds, int32 [N, K]; -1: no object."""
        return self.values[..., 0].astype(np.int32)

    @property
    def theme(self) -> np.ndarray:
        """Indices of images, float32 [N, K]."""
        return self.values[..., 1]

    @property
    def x(self) -> np.ndarray:
        """Centers, float32 [N, K]."""
        return self.values[..., 2]

    @property
    def y(self) -> np.ndarray:
        """Centers, float32 [N, K]."""
        return self.values[..., 3]

    @property
    def vx(self) -> np.ndarray:
        """Velocities, float32 [N, K]."""
        return self.values[..., 4]

    @property
    def vy(self) -> np.ndarray:
        """Velocities, float32 [N, K]."""
        return self.values[..., 5]

    @property
    def rx(self) -> np.ndarray:
        """Half-widths, float32 [N, K]."""
        return self.values[..., 6]

    @property
    def ry(self) -> np.ndarray:
        """Half-heights, float32 [N, K]."""
        return self.values[..., 7]

    @property
    def rotation(self) -> np.ndarray:
        """Radians, clockwise, float32 [N, K]."""
        return self.values[..., 8]

    @property
    def health(self) -> np.ndarray:
        """Health as the game defines it, float32 [N, K]."""
        return self.values[..., 9]

    def names(self, environment: int) -> list[str]:
        """Returns the names of the kinds of an environment's objects, in their order."""
        by_number = {kind: name for name, kind in kinds(self.games[environment]).items()}
        numbers = self.kind[environment].tolist()
        return [by_number.get(number, str(number)) for number in numbers if number >= 0]

    def positions_of(self, name: str) -> np.ndarray:
        """Returns the center of the first object of a kind, float32 [N, 2]; NaN without one.

        Raises:
            InvalidArgumentError: None of the games has such a kind.
        """
        numbers = [kinds(game).get(name, -2) for game in self.games]
        if numbers and max(numbers) < 0:
            known = {kind: None for game in self.games for kind in kinds(game)}
            raise InvalidArgumentError(f"name is {name!r}; it is one of {', '.join(known)}")
        matches = self.kind == np.array(numbers, np.int32)[:, None]
        rows = matches.argmax(axis=1)
        positions = self.values[np.arange(len(rows)), rows, 2:4]
        positions[~matches.any(axis=1)] = np.nan
        return positions


@functools.cache
def kinds(game: str) -> Mapping[str, int]:
    """Returns the numbers of the kinds of a game by their names, as the catalog has them."""
    (found,) = (each for each in catalog()["games"] if each["name"] == game)
    return {kind["name"]: kind["kind"] for kind in found["kinds"]}


@functools.cache
def goals(game: str) -> frozenset[str]:
    """Returns the names of the kinds that are goals of a game."""
    (found,) = (each for each in catalog()["games"] if each["name"] == game)
    return frozenset(kind["name"] for kind in found["kinds"] if kind["is_goal"])
