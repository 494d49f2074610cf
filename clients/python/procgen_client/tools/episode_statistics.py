"""Statistics of ended episodes: returns, lengths, levels."""

from __future__ import annotations

from collections import deque
from typing import Any, NamedTuple

import numpy as np

from procgen_client.batch import Batch
from procgen_client.errors import InvalidArgumentError


class Episode(NamedTuple):
    """An episode that has ended."""

    environment: int  # Index in the pool.
    level_seed: int  # Its last level.
    episode_return: float  # Sum of its rewards.
    length: int  # In steps.
    is_completed: bool  # Its last step completed the level.


class EpisodeStatistics:
    """Collects ended episodes, with means over the most recent ones.

    Attributes:
        episode_count: Number of collected episodes.
        recent: The last `window` episodes, oldest first.
    """

    def __init__(self, window: int = 100) -> None:
        """Starts without episodes.

        Args:
            window: Number of episodes in the means, at least 1.
        """
        if window < 1:
            raise InvalidArgumentError(f"window is {window}; it is at least 1")
        self.episode_count = 0
        self.recent: deque[Episode] = deque(maxlen=window)

    def add(self, step: Batch | dict[str, Any]) -> list[Episode]:
        """Collects the episodes that ended in a step, and returns them.

        Args:
            step: A batch of a pool, or the infos of a step of ProcgenVectorEnv.
        """
        episodes = _of_batch(step) if isinstance(step, Batch) else _of_infos(step)
        self.episode_count += len(episodes)
        self.recent += episodes
        return episodes

    @property
    def mean_return(self) -> float:
        """Mean return of `recent`; NaN if empty."""
        return _mean([episode.episode_return for episode in self.recent])

    @property
    def mean_length(self) -> float:
        """Mean length of `recent`, in steps; NaN if empty."""
        return _mean([episode.length for episode in self.recent])

    @property
    def completed_share(self) -> float:
        """Share of `recent` that completed their level; NaN if empty."""
        return _mean([episode.is_completed for episode in self.recent])


def _of_batch(batch: Batch) -> list[Episode]:
    return [
        Episode(
            batch.first_env + int(row),
            int(batch.prev_level_seeds[row]),
            float(batch.episode_returns[row]),
            int(batch.episode_lengths[row]),
            bool(batch.prev_level_complete[row]),
        )
        for row in np.flatnonzero(batch.ended)
    ]


def _of_infos(infos: dict[str, Any]) -> list[Episode]:
    if "episode_return" not in infos:
        return []
    infos = infos.get("final_info", infos)  # With SAME_STEP.
    return [
        Episode(
            int(row),
            int(infos["prev_level_seed"][row]),
            float(infos["episode_return"][row]),
            int(infos["episode_length"][row]),
            bool(infos["prev_level_complete"][row]),
        )
        for row in np.flatnonzero(infos["_episode_return"])
    ]


def _mean(values: list[Any]) -> float:
    return float(np.mean(values)) if values else float("nan")
