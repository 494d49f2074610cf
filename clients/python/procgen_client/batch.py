"""A batch: the arrays of a slice of a pool after a request; and their memory."""

from __future__ import annotations

import ctypes
import sys
from typing import Any

import numpy as np

# Element type of each array of a batch but the observations, in the order of ProcgenBatch.
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
# The arrays of ProcgenBatch, in order.
BATCH_ARRAYS = ("observations", *_NUMBER_TYPES, "final_observations")
# Whether the interpreter counts references exactly: not without its global lock.
_COUNTS_REFERENCES = getattr(sys, "_is_gil_enabled", lambda: True)()


class BatchStruct(ctypes.Structure):
    """ProcgenBatch of procgen.h."""

    _fields_ = (
        ("struct_size", ctypes.c_size_t),
        *((name, ctypes.c_void_p) for name in BATCH_ARRAYS),
    )


class Batch:
    """The values of n environments after a request. Row i is environment ``first_env + i``.

    All arrays belong to the caller and are writable. Their memory is used for a later batch only
    when nothing refers to this batch and its arrays. F is ``Pool.observation_shape``, by default
    64, 64, 3.
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
    fingerprints: np.ndarray  # Hashes of episodes; valid where one ended     uint64  [n]
    observations: Any  # Current ones, an array or `out`; None: not requested uint8   [n, *F]
    # Last observations of the episodes that ended; other rows are undefined. None: not requested.
    final_observations: np.ndarray | None  # uint8 [n, *F]

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
        """Makes arrays for `count` environments, with or without those of observations."""
        self.batch = Batch()
        self.struct = BatchStruct(struct_size=ctypes.sizeof(BatchStruct))
        for name, dtype in _NUMBER_TYPES.items():
            setattr(self.batch, name, np.zeros(count, dtype))
        self.batch.observations = np.empty((count, *shape), np.uint8) if observed else None
        self.batch.final_observations = np.zeros((count, *shape), np.uint8) if final else None
        arrays = {name: getattr(self.batch, name) for name in BATCH_ARRAYS}
        for name in arrays:
            setattr(self.struct, name, _address(arrays[name]))
        self.reference = ctypes.byref(self.struct)
        # Whatever a caller may keep of it.
        self.counted = (self.batch, *filter(lambda array: array is not None, arrays.values()))
        del arrays
        self.idle_count = self._reference_count()

    def set_observations(self, out: object, view: np.ndarray | None) -> None:
        """Has the observations written into a caller's memory, of which `view` is a view.

        Only of a batch without an array for observations. None: they are not written.
        """
        self.batch.observations = out
        self.struct.observations = _address(view)

    def is_idle(self) -> bool:
        """Whether no caller refers to the batch or to one of its arrays."""
        return _COUNTS_REFERENCES and self._reference_count() == self.idle_count

    def _reference_count(self) -> int:
        return sum(map(sys.getrefcount, self.counted))


def _address(array: np.ndarray | None) -> int | None:
    return None if array is None else array.ctypes.data
