"""The games: names, modes, time limits, ranges of returns, actions and their keys."""

from __future__ import annotations

import functools
import json
from typing import TypedDict, cast

from procgen_client import _library


class Mode(TypedDict, total=False):
    """A distribution mode of a game."""

    time_limit_steps: int  # Steps after which an episode is truncated.
    return_range: list[float] | None  # Returns that the paper normalises to 0 and 1, if it does.
    level_seed: int  # With "exploration" only: the seed of its one level.


class Kind(TypedDict):
    """A kind of a game's entities or cells."""

    kind: int  # Number, as in Objects.
    name: str
    is_goal: bool  # To reach it, or all of it, completes the level.


class Game(TypedDict):
    """A game."""

    name: str
    description: str
    modes: dict[str, Mode]  # By name.
    special_actions: dict[str, str]  # What actions 9 to 14 do, where they do something.
    kinds: list[Kind]
    variants: dict[str, str]  # Descriptions by name: see the option `variant`.


class Action(TypedDict):
    """An action, the same in all games."""

    name: str
    keys: list[str]  # Keys of a keyboard that are it.


class Catalog(TypedDict):
    """What the engine has."""

    actions: list[Action]
    games: list[Game]


@functools.cache
def catalog() -> Catalog:
    """Returns the catalog of the engine in this process. Do not modify it.

    Raises:
        OSError: libprocgen is not installed.
    """
    return cast(Catalog, json.loads(_library.library().catalog_json))
