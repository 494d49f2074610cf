"""RLlib's environments, over pools in its env runners or on servers."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.wrappers import TransformObservation
from gymnasium.wrappers.vector import TransformObservation as VectorTransformObservation

from procgen_client.envs.gym_env import ProcgenGymEnv
from procgen_client.envs.vector_env import ProcgenVectorEnv


def make_env(config: dict[str, Any]) -> Any:  # noqa: ANN401 - gymnasium.Env or VectorEnv
    """Makes the environments of an env runner, for ``ray.tune.register_env("procgen", make_env)``.

    Observations are float32 in [0, 1], since RLlib's networks do not convert uint8. With equal
    rand_seed the environments of all runners are slices of one larger set, so their levels differ.

    Args:
        config: RLlib's ``env_config``: ``games``, and other arguments of ProcgenVectorEnv, except
            autoreset_mode and first_env. RLlib adds ``num_envs`` with
            ``gym_env_vectorize_mode="vector_entry_point"``: one pool; without it, one environment.

    Errors as ProcgenVectorEnv.
    """
    options = dict(config)
    num_envs = options.pop("num_envs", None)
    # Runners have the indices from 1, or 0 if there is only the local one.
    runner = max(getattr(config, "worker_index", 0) - 1, 0)
    options["first_env"] = runner * (num_envs or 1)
    if num_envs is None:
        env = ProcgenGymEnv(**options)
        return TransformObservation(env, _scale, _scaled(env.observation_space))
    vector_env = ProcgenVectorEnv(num_envs=num_envs, **options)
    space = _scaled(vector_env.single_observation_space)
    return VectorTransformObservation(vector_env, _scale, single_observation_space=space)


def _scale(observations: np.ndarray) -> np.ndarray:
    return np.multiply(observations, np.float32(1 / 255), dtype=np.float32)


def _scaled(space: Any) -> gymnasium.spaces.Box:  # noqa: ANN401
    return gymnasium.spaces.Box(0, 1, space.shape, np.float32)
