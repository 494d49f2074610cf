"""Infos of environments from a batch.

Those of a vector environment are arrays, each with a mask `_key`. They are as those of Gymnasium's
own vector environments of ProcgenGymEnv: int64, float64 and bool; 0 where the mask is false; no key
where it is false everywhere.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from procgen_client.batch import Batch

# Element types of infos by the kind of a batch's: those of Python's numbers. Others stay.
_WIDE = {"i": np.int64, "f": np.float64}
_INT64 = np.dtype(np.int64)


def level_infos(batch: Batch, shown: np.ndarray, stepped: np.ndarray) -> dict[str, Any]:
    """Returns the levels after a step or a reset.

    Args:
        batch: Its answer.
        shown: Environments whose level is returned, bool [N].
        stepped: Those whose current episode has stepped a level, bool [N].
    """
    if stepped is shown:  # Most steps, all environments.
        mask = shown.copy()
        return {
            "level_seed": batch.level_seeds.astype(_INT64),
            "_level_seed": mask,
            "prev_level_seed": batch.prev_level_seeds.astype(_INT64),
            "_prev_level_seed": mask,
            "prev_level_complete": batch.prev_level_complete.copy(),
            "_prev_level_complete": mask,
        }
    infos: dict[str, Any] = {}
    _add_numbers(infos, shown, level_seed=batch.level_seeds)
    _add_numbers(infos, stepped, **_previous_level(batch))
    return infos


def episode_infos(batch: Batch, ended: np.ndarray, same_step: bool) -> dict[str, Any]:
    """Returns return and length of the episodes that ended in this step, `ended` bool [N].

    With SAME_STEP also their last observations and infos.
    """
    infos: dict[str, Any] = {}
    episode = {"episode_return": batch.episode_returns, "episode_length": batch.episode_lengths}
    _add_numbers(infos, ended, **episode)
    if not same_step:
        return infos

    final_obs = np.empty(batch.env_count, dtype=object)  # All None.
    assert batch.final_observations is not None
    for row in ended.nonzero()[0]:
        final_obs[row] = batch.final_observations[row].copy()
    final_info: dict[str, Any] = {}
    # The level in the last observation is the one that was stepped.
    _add_numbers(final_info, ended, level_seed=batch.prev_level_seeds, **_previous_level(batch))
    final_info |= infos  # Return and length.
    infos |= {"final_obs": final_obs, "_final_obs": ended.copy()}
    infos |= {"final_info": final_info, "_final_info": ended.copy()}
    return infos


def level_dicts(batch: Batch) -> list[dict[str, Any]]:
    """Returns the levels as upstream's get_info: a dict for each environment."""
    complete = batch.prev_level_complete.astype(np.uint8)
    return [
        {"prev_level_seed": previous, "prev_level_complete": is_complete, "level_seed": seed}
        for previous, is_complete, seed in zip(
            batch.prev_level_seeds, complete, batch.level_seeds
        )
    ]


def terminal_infos(batch: Batch) -> dict[int, dict[str, Any]]:
    """Returns, by environment, what Stable-Baselines3 reads where an episode ended in this step.

    ``terminal_observation``: the episode's last, {"rgb": uint8 [64, 64, 3]};
    ``TimeLimit.truncated``: whether the time limit ended it.
    """
    if batch.final_observations is None:  # Of a reset, or restored.
        return {}
    return {
        int(row): {
            "terminal_observation": {"rgb": batch.final_observations[row].copy()},
            "TimeLimit.truncated": bool(batch.truncated[row]),
        }
        for row in np.flatnonzero(batch.ended)
    }


def _previous_level(batch: Batch) -> dict[str, np.ndarray]:
    return {
        "prev_level_seed": batch.prev_level_seeds,
        "prev_level_complete": batch.prev_level_complete,
    }


def _add_numbers(infos: dict[str, Any], mask: np.ndarray, **numbers: np.ndarray) -> None:
    """Adds arrays [N] by name, with a mask that is true somewhere; else none."""
    count = np.count_nonzero(mask)  # Five times as fast as any().
    if not count:
        return
    for name, values in numbers.items():
        dtype = _WIDE.get(values.dtype.kind, values.dtype)
        # np.where takes five times as long.
        is_whole = count == len(mask)
        infos[name] = values.astype(dtype) if is_whole else np.multiply(values, mask, dtype=dtype)
        infos[f"_{name}"] = mask.copy()
