"""Spaces with Gymnasium's names and attributes, for installations without Gymnasium."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


class Space:
    """Base class of spaces: shape, element type, samples."""

    def __init__(self, shape: tuple[int, ...], dtype: npt.DTypeLike) -> None:
        """Takes the shape and the element type."""
        self.shape = shape
        self.dtype = np.dtype(dtype)
        self._random = np.random.default_rng()

    def __contains__(self, value: object) -> bool:
        """Whether value is an element."""
        return self.contains(value)

    def contains(self, value: object) -> bool:
        """Whether value is an element: shape, kind and bounds match."""
        raise NotImplementedError

    def sample(self) -> Any:  # noqa: ANN401 - an int or an array
        """Returns a random element."""
        raise NotImplementedError

    def seed(self, seed: int | None = None) -> None:
        """Seeds the samples."""
        self._random = np.random.default_rng(seed)

    def _fits(self, value: object) -> bool:
        array = np.asarray(value)
        return array.shape == self.shape and array.dtype.kind in "iu"


class Box(Space):
    """Arrays with elements in [low, high]."""

    def __init__(self, low: int, high: int, shape: tuple[int, ...], dtype: npt.DTypeLike) -> None:
        """Takes the bounds, which are inclusive."""
        super().__init__(shape, dtype)
        self.low = np.full(shape, low, dtype)
        self.high = np.full(shape, high, dtype)
        self._bounds = (low, high)

    def __repr__(self) -> str:
        """Returns e.g. ``Box(0, 255, (64, 64, 3), uint8)``."""
        low, high = self._bounds
        return f"Box({low}, {high}, {self.shape}, {self.dtype})"

    def contains(self, value: object) -> bool:
        """Whether value is an element."""
        array = np.asarray(value)
        return self._fits(value) and bool(np.all((array >= self.low) & (array <= self.high)))

    def sample(self) -> np.ndarray:
        """Returns a random element."""
        return self._random.integers(self.low, self.high, endpoint=True).astype(self.dtype)


class Discrete(Space):
    """The integers in [0, n)."""

    def __init__(self, n: int) -> None:
        """Takes n."""
        super().__init__((), np.int64)
        self.n = n

    def __repr__(self) -> str:
        """Returns e.g. ``Discrete(15)``."""
        return f"Discrete({self.n})"

    def contains(self, value: object) -> bool:
        """Whether value is an element."""
        return self._fits(value) and 0 <= int(np.asarray(value)) < self.n

    def sample(self) -> np.int64:
        """Returns a random element."""
        return np.int64(self._random.integers(self.n))


class MultiDiscrete(Space):
    """Arrays of integers, element i in [0, nvec[i])."""

    def __init__(self, nvec: npt.ArrayLike) -> None:
        """Takes the exclusive bound of each element."""
        self.nvec = np.asarray(nvec, np.int64)
        super().__init__(self.nvec.shape, np.int64)

    def __repr__(self) -> str:
        """Returns e.g. ``MultiDiscrete([15 15])``."""
        return f"MultiDiscrete({self.nvec})"

    def contains(self, value: object) -> bool:
        """Whether value is an element."""
        array = np.asarray(value)
        return self._fits(value) and bool(np.all((array >= 0) & (array < self.nvec)))

    def sample(self) -> np.ndarray:
        """Returns a random element."""
        return self._random.integers(self.nvec)


class Dict(Space):
    """Dictionaries with an element of each space."""

    def __init__(self, spaces: dict[str, Space]) -> None:
        """Takes the spaces by name."""
        super().__init__((), object)
        self.spaces = dict(spaces)

    def __repr__(self) -> str:
        """Returns e.g. ``Dict('rgb': Box(0, 255, (64, 64, 3), uint8))``."""
        return f"Dict({', '.join(f'{name!r}: {space}' for name, space in self.spaces.items())})"

    def __getitem__(self, name: str) -> Space:
        """Returns the space with that name."""
        return self.spaces[name]

    def contains(self, value: object) -> bool:
        """Whether value is an element."""
        return (
            isinstance(value, dict)
            and value.keys() == self.spaces.keys()
            and all(space.contains(value[name]) for name, space in self.spaces.items())
        )

    def sample(self) -> dict[str, Any]:
        """Returns a random element."""
        return {name: space.sample() for name, space in self.spaces.items()}

    def seed(self, seed: int | None = None) -> None:
        """Seeds the samples of all spaces."""
        for space in self.spaces.values():
            space.seed(seed)
