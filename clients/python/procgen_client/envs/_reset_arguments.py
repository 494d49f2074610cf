"""The arguments of a vector environment's reset. Malformed ones raise InvalidArgumentError."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from procgen_client._requests import LEVEL_SEEDS, in_range
from procgen_client.errors import InvalidArgumentError
from procgen_client.options import check_names

_SEED_MAX = 2**32 - 1
# Two spellings of the same option: upstream's info is `level_seed`, and there are several.
_LEVEL_OPTIONS = ("level_seed", "level_seeds")
_VECTOR_OPTIONS = (*_LEVEL_OPTIONS, "reset_mask")


class ResetOptions(NamedTuple):
    """The options of a reset of N environments."""

    mask: np.ndarray  # Environments that are reset, bool [N].
    levels: list[int | None]  # Level of each environment; None: chosen.


def reset_options_of(
    options: Mapping[str, Any] | None, num_envs: int, owner: str, *, is_single: bool = False
) -> ResetOptions:
    """Returns the options of a reset.

    Args:
        options: As the caller gave them, or None.
        num_envs: Number of environments, N.
        owner: Class of the environment, for messages.
        is_single: Whether it is one environment, which has no reset_mask.

    Raises:
        UnknownOptionError: An option is unknown.
        InvalidArgumentError: An option is malformed.
    """
    options = {} if options is None else options
    allowed = _LEVEL_OPTIONS if is_single else _VECTOR_OPTIONS
    check_names(f"{owner}.reset", options, allowed)
    given = [(name, options[name]) for name in _LEVEL_OPTIONS if options.get(name) is not None]
    if len(given) > 1:
        raise InvalidArgumentError("level_seed and level_seeds are both given; give one")
    levels = _levels_of(*given[0], num_envs) if given else [None] * num_envs
    return ResetOptions(_mask_of(options.get("reset_mask"), num_envs), levels)


def seeds_of(seed: int | Sequence[int | None] | None, num_envs: int) -> list[int | None]:
    """Returns the seed of each environment's choice of levels; None: unchanged."""
    if seed is None:
        return [None] * num_envs
    if isinstance(seed, (Sequence, np.ndarray)) and not isinstance(seed, str):
        _check_length("seed", seed, num_envs)
        return [
            None if value is None else in_range(f"seed[{i}]", value, 0, _SEED_MAX)
            for i, value in enumerate(seed)
        ]
    first = in_range("seed", seed, 0, _SEED_MAX + 1 - num_envs)
    return [first + i for i in range(num_envs)]


def _mask_of(given: object, num_envs: int) -> np.ndarray:
    if given is None:
        return np.ones(num_envs, np.bool_)
    if not isinstance(given, np.ndarray) or given.dtype != np.bool_ or given.shape != (num_envs,):
        raise InvalidArgumentError(f"reset_mask is not a bool array of shape [{num_envs}]")
    if not given.any():
        raise InvalidArgumentError("reset_mask has no True; it has at least one")
    return given


def _levels_of(name: str, given: Any, num_envs: int) -> list[int | None]:  # noqa: ANN401
    """Returns the level of each environment; a number is that of all."""
    if np.ndim(given) == 0:
        return [in_range(name, given, *LEVEL_SEEDS)] * num_envs
    _check_length(name, given, num_envs)
    return [in_range(f"{name}[{i}]", value, *LEVEL_SEEDS) for i, value in enumerate(given)]


def _check_length(name: str, given: Sequence[Any] | np.ndarray, num_envs: int) -> None:
    if len(given) != num_envs:
        raise InvalidArgumentError(
            f"{name} has {len(given)} entries; there are {num_envs} environments"
        )
