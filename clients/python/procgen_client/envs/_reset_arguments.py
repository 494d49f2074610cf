"""The arguments of a vector environment's reset. Malformed ones raise InvalidArgumentError."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from procgen_client.errors import InvalidArgumentError


def reset_mask_of(given: object, num_envs: int) -> np.ndarray:
    """Returns the mask, bool [N]; None: all."""
    if given is None:
        return np.ones(num_envs, np.bool_)
    if not isinstance(given, np.ndarray) or given.dtype != np.bool_ or given.shape != (num_envs,):
        raise InvalidArgumentError(f"reset_mask is not a bool array of shape [{num_envs}]")
    if not given.any():
        raise InvalidArgumentError("reset_mask has no True; it has at least one")
    return given


def seeds_of(seed: int | Sequence[int | None] | None, num_envs: int) -> list[int | None]:
    """Returns the seed of each environment's choice of levels; None: unchanged."""
    if seed is None:
        return [None] * num_envs
    if isinstance(seed, int | np.integer):
        return [int(seed) + i for i in range(num_envs)]
    if len(seed) != num_envs:
        raise InvalidArgumentError(
            f"seed has {len(seed)} entries; there are {num_envs} environments"
        )
    return [None if value is None else int(value) for value in seed]


def level_seeds_of(given: Sequence[int] | None, num_envs: int) -> list[int | None]:
    """Returns the level of each environment; None: chosen."""
    if given is None:
        return [None] * num_envs
    if len(given) != num_envs:
        raise InvalidArgumentError(
            f"level_seeds has {len(given)} entries; there are {num_envs} environments"
        )
    return [int(value) for value in given]
