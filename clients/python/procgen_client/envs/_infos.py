"""Infos of a Gymnasium vector environment from a batch: arrays, each with a mask `_key`."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from procgen_client.batch import Batch


def level_infos(batch: Batch, mask: np.ndarray) -> dict[str, Any]:
    """Returns the levels of a step; `mask`, bool [N], is the mask of each entry."""
    return {
        "level_seed": batch.level_seeds,
        "_level_seed": mask.copy(),
        "prev_level_seed": batch.prev_level_seeds,
        "_prev_level_seed": mask.copy(),
        "prev_level_complete": batch.prev_level_complete,
        "_prev_level_complete": mask.copy(),
    }


def reset_infos(batch: Batch, mask: np.ndarray) -> dict[str, Any]:
    """Returns the levels after a reset of the environments of `mask`, bool [N].

    The masks of prev_* are false, since the new episodes have stepped no level.
    """
    nowhere = np.zeros_like(mask)
    infos: dict[str, Any] = {"level_seed": batch.level_seeds, "_level_seed": mask.copy()}
    _add_numbers(infos, "prev_level_seed", batch.prev_level_seeds, nowhere)
    _add_numbers(infos, "prev_level_complete", batch.prev_level_complete, nowhere)
    return infos


def episode_infos(batch: Batch, ended: np.ndarray, same_step: bool) -> dict[str, Any]:
    """Returns return and length of the episodes that ended in this step, `ended` bool [N].

    With SAME_STEP also their last observations and infos.
    """
    infos: dict[str, Any] = {}
    _add_numbers(infos, "episode_return", batch.episode_returns, ended)
    _add_numbers(infos, "episode_length", batch.episode_lengths, ended)
    if not same_step:
        return infos

    final_obs = np.empty(batch.env_count, dtype=object)  # All None.
    for row, observation in zip(ended.nonzero()[0], batch.final_observations, strict=True):
        final_obs[row] = observation.copy()
    final_info: dict[str, Any] = {}
    # The level in the last observation.
    _add_numbers(final_info, "level_seed", batch.prev_level_seeds, ended)
    _add_numbers(final_info, "prev_level_seed", batch.prev_level_seeds, ended)
    _add_numbers(final_info, "prev_level_complete", batch.prev_level_complete, ended)
    final_info |= infos  # Return and length.
    infos |= {"final_obs": final_obs, "_final_obs": ended.copy()}
    infos |= {"final_info": final_info, "_final_info": ended.copy()}
    return infos


class EpisodeRecorder:
    """Makes the info `episode`, as Gymnasium's RecordEpisodeStatistics."""

    def __init__(self, num_envs: int) -> None:
        """Starts without episodes; call begin for those that a reset starts."""
        self._begin_times = np.zeros(num_envs)

    def begin(self, mask: np.ndarray) -> None:
        """Starts the time of the episodes of `mask`, bool [N]."""
        self._begin_times[mask] = time.perf_counter()

    def infos(self, batch: Batch, ended: np.ndarray) -> dict[str, Any]:
        """Returns return, length and time of the episodes that ended, `ended` bool [N]; or {}.

        ``r`` float64 [N], ``l`` int64 [N], ``t`` float64 [N], in seconds.
        """
        infos: dict[str, Any] = {}
        if ended.any():
            seconds = np.round(time.perf_counter() - self._begin_times, 6)
            episode = {
                "r": batch.episode_returns.astype(np.float64) * ended,
                "l": batch.episode_lengths.astype(np.int64) * ended,
                "t": seconds * ended,
            }
            infos = {"episode": episode, "_episode": ended.copy()}
        self.begin(batch.first)
        return infos


def _add_numbers(infos: dict[str, Any], name: str, values: np.ndarray, mask: np.ndarray) -> None:
    infos[name] = values * mask  # Keeps the type; np.where takes five times as long.
    infos[f"_{name}"] = mask.copy()
