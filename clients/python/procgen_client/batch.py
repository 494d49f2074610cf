"""A batch: the arrays of a slice of a pool after a request."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from procgen_client import _native


@dataclass(slots=True)
class Batch:
    """The values of n environments after a request. Row i is environment ``first_env + i``.

    All arrays belong to the caller and are writable. ``observations`` and ``final_observations``
    may borrow the memory that the answer was received into; it is reused when no array refers to
    it. The other arrays are copies.

    With transport "shared_memory" and ``copy=False`` (Client.create_pool) observations are
    **read-only** views of memory that the server renders into (``.copy()`` returns a writable
    array). The server overwrites a batch only when no array refers to it, so copy what you keep
    (``held_batches_max``). After another learner took the pool over, this is not guaranteed.

    F is the shape of one observation, ``Pool.observation_shape``: by default 64, 64, 3.

    ``observations`` is None after a request with ``observe=False``; ``final_observations`` is empty
    unless requested.
    """

    sequence_number: int  # Number of the request that this answers.
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
    fingerprints: np.ndarray  # Hashes of episodes that ended, in order       uint64  [m]
    final_observations: np.ndarray  # Last ones of those episodes; or empty   uint8   [m, *F]
    observations: np.ndarray | None  # Current observations                   uint8   [n, *F]

    @property
    def env_count(self) -> int:
        """Number of rows, n."""
        return len(self.rewards)

    @property
    def ended(self) -> np.ndarray:
        """Whether an episode ended in this step, terminated or truncated; bool [n]."""
        ended: np.ndarray = self.terminated | self.truncated
        return ended


class ReceivedBatch(Batch):
    """A batch that makes its arrays on first access, since a learner reads few of them."""

    __slots__ = ("_received",)

    _received: _native.Batch

    def __getattr__(self, name: str) -> np.ndarray | None:
        """Makes an array and stores it as an attribute; called once per array."""
        if name not in Batch.__dataclass_fields__:
            raise AttributeError(f"a batch has no {name}")
        array = self._received.array(name)
        setattr(self, name, array)
        return array


def batch_of(received: _native.Batch, *, owned: bool) -> Batch:
    """Returns an answer as a Batch.

    Args:
        received: The answer.
        owned: Make all arrays now and copy views, so that `received` is released.
    """
    batch = ReceivedBatch.__new__(ReceivedBatch)
    batch.sequence_number = received.sequence_number
    batch.first_env = received.first_env
    if not owned:
        batch._received = received
        return batch
    for name in _ARRAYS:
        array = received.array(name)
        setattr(batch, name, array if array is None or array.flags.writeable else array.copy())
    return batch


# Fields of a batch that are arrays.
_ARRAYS = [
    name for name in Batch.__dataclass_fields__ if name not in ("sequence_number", "first_env")
]
