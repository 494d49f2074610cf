"""A batch's numbers as infos of a Gymnasium vector environment: arrays, each with a mask `_key`."""

from __future__ import annotations

from typing import Any

import numpy as np

from procgen_client.batch import Batch


def level_infos(batch: Batch, mask: np.ndarray) -> dict[str, Any]:
    """Gives what is known of the levels, for the environments of `mask` (bool [N])."""
    return {
        "level_seed": batch.level_seeds,
        "_level_seed": mask.copy(),
        "prev_level_seed": batch.prev_level_seeds,
        "_prev_level_seed": mask.copy(),
        "prev_level_complete": batch.prev_level_complete,
        "_prev_level_complete": mask.copy(),
    }


def episode_infos(batch: Batch, ended: np.ndarray, same_step: bool) -> dict[str, Any]:
    """Gives what is known of the episodes of `ended` (bool [N]), which have ended in this step.

    With SAME_STEP also what they showed last.
    """
    infos: dict[str, Any] = {}
    _add_info(infos, "episode_return", np.where(ended, batch.episode_returns, 0), ended)
    _add_info(infos, "episode_length", np.where(ended, batch.episode_lengths, 0), ended)
    if not same_step:
        return infos

    final_obs = np.full(batch.environment_count, None, dtype=object)
    for row, observation in zip(np.flatnonzero(ended), batch.final_observations, strict=True):
        final_obs[row] = observation.copy()
    final_info: dict[str, Any] = {}
    for name, values in (
        ("level_seed", batch.prev_level_seeds),  # The level that the last observation shows.
        ("prev_level_seed", batch.prev_level_seeds),
        ("prev_level_complete", batch.prev_level_complete),
    ):
        _add_info(final_info, name, np.where(ended, values, 0).astype(values.dtype), ended)
    _add_info(infos, "final_obs", final_obs, ended)
    _add_info(infos, "final_info", final_info, ended)
    return infos


def _add_info(infos: dict[str, Any], name: str, values: object, mask: np.ndarray) -> None:
    infos[name] = values
    infos[f"_{name}"] = mask.copy()
