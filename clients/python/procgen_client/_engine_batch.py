"""The arrays of a batch, and their memory, which is used again when nobody refers to it."""

from __future__ import annotations

import ctypes
import sys
from typing import Any

import numpy as np

from procgen_client import _library

# Element type of each array of a batch but the observations.
_NUMBER_TYPES = {
    "rewards": np.float32,
    "first": np.bool_,
    "terminated": np.bool_,
    "truncated": np.bool_,
    "level_seeds": np.int32,
    "prev_level_seeds": np.int32,
    "prev_level_complete": np.bool_,
    "episode_returns": np.float32,
    "episode_lengths": np.int32,
    "fingerprints": np.uint64,
}
# Whether the interpreter counts references exactly: not without its global lock.
_COUNTS_REFERENCES = getattr(sys, "_is_gil_enabled", lambda: True)()


class EngineBatch:
    """The values of n environments after a request. Row i is environment ``first_env + i``.

    All arrays belong to the caller and are writable. F is ``EnginePool.observation_shape``.
    """

    __slots__ = ("first_env", *_NUMBER_TYPES, "observations", "final_observations", "__weakref__")

    first_env: int  # Index in the pool of row 0.
    rewards: np.ndarray  # Of this step; of the ended episode where one ended float32 [n]
    first: np.ndarray  # A new episode has begun                              bool    [n]
    terminated: np.ndarray  # The game (or action -1) ended the episode       bool    [n]
    truncated: np.ndarray  # The time limit ended the episode                 bool    [n]
    level_seeds: np.ndarray  # Level in the observation                       int32   [n]
    prev_level_seeds: np.ndarray  # Level that was stepped                    int32   [n]
    prev_level_complete: np.ndarray  # That level was completed by this step  bool    [n]
    episode_returns: np.ndarray  # Of the ended or running episode            float32 [n]
    episode_lengths: np.ndarray  # Of the same episode, in steps              int32   [n]
    fingerprints: np.ndarray  # Hashes of episodes that ended in this step    uint64  [n]
    observations: Any  # Current observations; None: not requested            uint8   [n, *F]
    final_observations: np.ndarray | None  # Last ones of episodes that ended  uint8  [n, *F]

    @property
    def env_count(self) -> int:
        """Number of rows, n."""
        return len(self.rewards)

    @property
    def ended(self) -> np.ndarray:
        """Whether an episode ended in this step, terminated or truncated; bool [n]."""
        ended: np.ndarray = self.terminated | self.truncated
        return ended


class Buffers:
    """Memory of a batch: the arrays, and the C struct that points to them."""

    __slots__ = ("batch", "counted", "idle_count", "reference", "struct")

    def __init__(self, count: int, shape: tuple[int, ...], observed: bool, final: bool) -> None:
        self.batch = EngineBatch()
        self.struct = _library.Batch(struct_size=ctypes.sizeof(_library.Batch))
        for name, dtype in _NUMBER_TYPES.items():
            setattr(self.batch, name, np.zeros(count, dtype))
        self.batch.observations = np.zeros((count, *shape), np.uint8) if observed else None
        self.batch.final_observations = np.zeros((count, *shape), np.uint8) if final else None
        for name in _library.BATCH_ARRAYS:
            array = getattr(self.batch, name)
            setattr(self.struct, name, None if array is None else array.ctypes.data)
        self.reference = ctypes.byref(self.struct)
        # Whatever a caller may keep of it.
        arrays = (getattr(self.batch, name) for name in _library.BATCH_ARRAYS)
        self.counted = (self.batch, *(array for array in arrays if array is not None))
        self.idle_count = 0
        self.idle_count = self._reference_count()

    def is_idle(self) -> bool:
        """Whether no caller refers to the batch or to one of its arrays."""
        return _COUNTS_REFERENCES and self._reference_count() == self.idle_count

    def _reference_count(self) -> int:
        return sum(map(sys.getrefcount, self.counted))
