"""Gym's spaces, ids and Env for upstream's API, where Gym is installed."""

from __future__ import annotations

import functools
import sys
import warnings
from importlib.util import find_spec
from typing import Any

import numpy as np

from procgen_client.envs._gymnasium import spaces
from procgen_client.errors import InvalidArgumentError
from procgen_client.options import GAMES


def program_spaces() -> Any:  # noqa: ANN401 - a module
    """Returns the module of spaces: Gym's, as upstream, if the program has imported Gym.

    Otherwise Gymnasium's, or that of this package.
    """
    gym = sys.modules.get("gym")
    return spaces if gym is None else gym.spaces


def make_env(
    env_name: str, render_mode: str | None = None, render: bool = False, **options: Any
) -> Any:  # noqa: ANN401 - gym.Env, which may not be installed
    """Makes one environment with the API of Gym until 0.21, as upstream's Gym ids do.

    Args:
        env_name: The game.
        render_mode: "rgb_array", or None.
        render: Must be False. Upstream opens a window if True.
        **options: As for ProcgenGym3Env.

    Raises:
        InvalidArgumentError: `render`, or render_mode "human".
        ProcgenError: As ProcgenGym3Env.
    """
    if render or render_mode == "human":
        raise InvalidArgumentError(
            "render_mode is 'human'; it is None or 'rgb_array', since no window is opened"
        )
    return _env_class()(env_name, render_mode=render_mode, **options)


def register_environments() -> None:
    """Registers upstream's ids, ``procgen-coinrun-v0``, with Gym, if the program has imported it.

    Does nothing if the package `procgen` is installed, which has these ids.
    """
    gym = sys.modules.get("gym")
    if gym is None or find_spec("procgen") is not None:
        return
    for game in GAMES:
        gym.envs.registration.register(
            id=f"procgen-{game}-v0",
            entry_point="procgen_client.envs._gym:make_env",
            kwargs={"env_name": game},
        )


@functools.cache
def _env_class() -> Any:  # noqa: ANN401 - a subclass of gym.Env, which may not be installed
    import gym

    from procgen_client.envs.baselines_env import ProcgenEnv

    class ProcgenGymEnv(gym.Env):
        """One environment: reset returns an observation, step returns four values.

        As in upstream, only the game ends an episode: reset within an episode and seed just warn.
        The step that ends an episode returns the observation before it.
        """

        metadata = ProcgenEnv.metadata

        def __init__(self, env_name: str, **options: Any) -> None:
            self.venv = ProcgenEnv(1, env_name, **options)
            self.render_mode = self.venv.render_mode
            self.observation_space = self.venv.observation_space["rgb"]
            self.action_space = self.venv.action_space

        def reset(self) -> np.ndarray:
            observation: np.ndarray = self.venv.reset()["rgb"][0]
            return observation

        def step(self, action: int) -> tuple[np.ndarray, float, bool, dict[str, Any]]:
            before = self.venv.env.observe()[1]["rgb"][0]
            observations, rewards, dones, infos = self.venv.step(np.array([action]))
            is_over = bool(dones[0])
            observation = before if is_over else observations["rgb"][0]
            return observation, float(rewards[0]), is_over, infos[0]

        def render(self, mode: str = "human") -> np.ndarray | None:
            return self.venv.render(mode)

        def seed(self, seed: int | None = None) -> None:
            warnings.warn("seed does nothing: pass rand_seed to gym.make", stacklevel=2)

        def close(self) -> None:
            if hasattr(self, "venv"):  # False if __init__ failed.
                self.venv.close()

    return ProcgenGymEnv
