"""Settings of worlds and of episodes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from procgen_client._requests import LEVEL_SEEDS, in_range
from procgen_client.dm_env_rpc import _tensors
from procgen_client.errors import InvalidArgumentError
from procgen_client.options import DISTRIBUTION_MODES, PoolOptions, check_names

# Options of a Pool that are no settings: a tensor does not express them, or they are the program's.
_NO_SETTINGS = frozenset({"level_sampler", "num_threads", "encoding"})
_WORLD = frozenset({"env_name", "num_envs", *PoolOptions.__annotations__} - _NO_SETTINGS)
_EPISODE = frozenset({"level_seed", "rand_seed"})
_RAND_SEEDS = (-(2**63), 2**63 - 1)
_MODE_NAMES = {number: name for name, number in DISTRIBUTION_MODES.items()}
# Largest number of environments of a world, of which each has 12 KiB of observations at least.
_ENV_COUNT_MAX = 65536


def pool_arguments(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the arguments of Pool for the settings of create_world; Pool validates the values.

    Raises:
        InvalidArgumentError: A setting is unknown, no scalar and no list, or env_name is missing.
    """
    check_names("create_world", settings, _WORLD)
    values = {
        name: _tensors.unpack(
            name, tensor, _tensors.VALUE, _tensors.ANY if len(tensor.shape) else None
        )
        for name, tensor in settings.items()
    }
    if "env_name" not in values:
        raise InvalidArgumentError("settings have no env_name, required: the name of a game")
    values["games"] = values.pop("env_name")
    mode = values.get("distribution_mode")
    if isinstance(mode, int):
        values["distribution_mode"] = _MODE_NAMES.get(mode, mode)
    if "num_envs" in values:
        count = in_range("num_envs", values.pop("num_envs"), 1, _ENV_COUNT_MAX)
        return {**values, "env_count": count, "autoreset_mode": "same_step"}
    # One environment, as a world with the states of the protocol.
    return {**values, "env_count": 1, "autoreset_mode": "disabled", "num_threads": 0}


def episode_settings(
    settings: Mapping[str, Any], env_count: int | None
) -> tuple[dict[int, int], dict[int, int]]:
    """Returns the levels and the new seeds of a reset, by environment.

    Args:
        settings: Tensors by name, with a value for each environment. A scalar is the level of all,
            or the first of successive seeds.
        env_count: None: a single environment, not a batch.

    Raises:
        InvalidArgumentError: A setting is unknown, or has another type, shape or value.
    """
    check_names("a reset", settings, _EPISODE)
    read: dict[str, dict[int, int]] = {name: {} for name in _EPISODE}
    for name, tensor in settings.items():
        is_list = env_count is not None and len(tensor.shape) > 0
        given = _tensors.unpack(name, tensor, _tensors.INTEGER, env_count if is_list else None)
        for i, value in enumerate(given if is_list else [given] * (env_count or 1)):
            if name == "level_seed":
                read[name][i] = in_range(name, value, *LEVEL_SEEDS)
            else:  # As the engine uses it.
                seed = in_range(name, value, *_RAND_SEEDS)
                read[name][i] = (seed if is_list else seed + i) % 2**32
    return read["level_seed"], read["rand_seed"]
