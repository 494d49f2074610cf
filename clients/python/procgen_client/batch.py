"""A batch: the values of a slice of a pool after a request, as arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from procgen_client._transport.wire import Part


@dataclass(slots=True)
class Batch:
    """How n environments stand after a request.

    Row i is environment ``first_env + i`` of the pool.

    ``observations`` and ``final_observations`` are views of the received message: nothing is
    copied, they stay valid as long as they are referred to, they are never written again, and they
    are **read-only** (``.copy()`` gives a writable one). Where an answer came in several responses
    they are one joined array instead, and observations of a pool with an encoding are decoded ones.
    All other arrays are the caller's own and writable.

    Of a pool with transport "shared_memory" they are views of the memory that the server draws
    into. It does so again only when no array refers to that batch any more; so copy what is kept
    for long (Client.create_pool, ``held_batches_max``). Who takes the pool over ends that promise.

    F is the shape of one observation, ``Pool.observation_shape``: by default 64, 64, 3.

    After a request without pictures (``observe=False``) ``observations`` is None;
    ``final_observations`` is empty unless asked for.
    """

    sequence_number: int  # Number of the request that this answers.
    first_env: int  # Index in the pool of row 0.
    rewards: np.ndarray  # Of this step, the old episode's where one ended    float32 [n]
    first: np.ndarray  # A new episode has begun                              bool    [n]
    terminated: np.ndarray  # The game (or action -1) ended the episode       bool    [n]
    truncated: np.ndarray  # The time limit ended the episode                 bool    [n]
    level_seeds: np.ndarray  # Level in the observation                       int32   [n]
    prev_level_seeds: np.ndarray  # Level that was stepped                    int32   [n]
    prev_level_complete: np.ndarray  # That level was completed by this step  bool    [n]
    episode_returns: np.ndarray  # Of the ended or running episode            float32 [n]
    episode_lengths: np.ndarray  # Of the same, in steps                      int32   [n]
    fingerprints: np.ndarray  # Hashes of episodes that ended, in order       uint64  [m]
    final_observations: np.ndarray  # Last ones of those; or empty            uint8   [m, *F]
    observations: np.ndarray | None  # What the agents see                    uint8   [n, *F]

    @property
    def env_count(self) -> int:
        """Number of rows, n."""
        return len(self.rewards)

    @property
    def ended(self) -> np.ndarray:
        """Whether an episode ended in this step, one way or the other; bool [n]."""
        return self.terminated | self.truncated


def assemble(parts: list[Part], observation_shape: tuple[int, ...]) -> Batch:
    """Joins the responses to one request, which have been checked as they came."""
    first_part = parts[0]
    if len(parts) == 1:
        arrays = first_part.arrays
    else:
        names = first_part.arrays
        arrays = {name: np.concatenate([part.arrays[name] for part in parts]) for name in names}

    observations = arrays.pop("observations").reshape(-1, *observation_shape)
    final_observations = arrays.pop("final_observations").reshape(-1, *observation_shape)
    return Batch(
        sequence_number=first_part.sequence_number,
        first_env=first_part.first_env,
        observations=observations if len(observations) else None,
        final_observations=final_observations,
        **arrays,
    )
