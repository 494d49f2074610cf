"""Gym's spaces, ids and Env for upstream's API, where Gym is installed."""

from __future__ import annotations

import functools
import sys
import warnings
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from procgen_client.envs._gymnasium import HAS_GYMNASIUM, spaces
from procgen_client.errors import InvalidArgumentError
from procgen_client.options import GAMES
from procgen_client.tools.art import upstream_is_installed

# Modules before the colon of ids, as in "procgen:procgen-coinrun-v0".
_ID_MODULES = ("procgen", "procgen_client")
# Versions of Gym that look up an id with its module before they import the module.
_VERSIONS_WITH_MODULE_IN_ID = ("0.22.", "0.23.")


def program_spaces() -> Any:  # noqa: ANN401 - a module
    """Returns the module of spaces: Gym's, as upstream, if the program has imported Gym.

    Otherwise Gymnasium's; where that is not installed Gym's, else that of this package.
    """
    gym = sys.modules.get("gym")
    if gym is None and not HAS_GYMNASIUM and find_spec("gym") is not None:
        gym = import_module("gym")
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

    Calling again registers nothing. Nor is anything registered where upstream is installed, which
    has these ids.
    """
    gym = sys.modules.get("gym")
    if gym is None or upstream_is_installed() or _is_registered(gym):
        return
    prefixes = [""]
    if gym.__version__.startswith(_VERSIONS_WITH_MODULE_IN_ID):
        prefixes += [f"{module}:" for module in _ID_MODULES]
    for game in GAMES:
        for prefix in prefixes:
            gym.envs.registration.register(
                id=f"{prefix}procgen-{game}-v0",
                entry_point="procgen_client.envs._gym:make_env",
                kwargs={"env_name": game},
            )


def _is_registered(gym: Any) -> bool:  # noqa: ANN401 - a module
    registry = gym.envs.registration.registry
    return f"procgen-{GAMES[0]}-v0" in getattr(registry, "env_specs", registry)


@functools.cache
def _env_class() -> Any:  # noqa: ANN401 - a subclass of gym.Env, which may not be installed
    import gym

    from procgen_client.envs.baselines_env import ProcgenEnv
    from procgen_client.envs.procgen_compat import ProcgenGym3Env

    class ProcgenGymEnv(gym.Env):
        """One environment: reset returns an observation, step returns four values.

        As in upstream, only the game ends an episode: reset within an episode and seed just warn.
        The step that ends an episode returns the observation before it. Its infos are upstream's.
        """

        metadata = ProcgenEnv.metadata

        def __init__(self, env_name: str, **options: Any) -> None:
            self.venv = ProcgenEnv(1, env_name, **options)
            self.render_mode = self.venv.render_mode
            self.observation_space = self.venv.observation_space["rgb"]
            self.action_space = self.venv.action_space

        @property
        def env(self) -> ProcgenGym3Env:
            """The gym3 environment, for programs that look for its get_info."""
            return self.venv.env

        def reset(self) -> np.ndarray:
            observation: np.ndarray = self.venv.reset()["rgb"][0]
            return observation

        def step(self, action: int) -> tuple[np.ndarray, float, bool, dict[str, Any]]:
            before = self.venv.env.observe()[1]["rgb"][0]
            observations, rewards, dones, _ = self.venv.step(np.array([action]))
            is_over = bool(dones[0])
            observation = before if is_over else observations["rgb"][0]
            return observation, float(rewards[0]), is_over, self.env.get_info()[0]

        def render(self, mode: str = "human") -> np.ndarray | None:
            return self.venv.render(mode)

        def seed(self, seed: int | None = None) -> None:
            warnings.warn("seed does nothing: pass rand_seed to gym.make", stacklevel=2)

        def close(self) -> None:
            if hasattr(self, "venv"):  # False if __init__ failed.
                self.venv.close()

    return ProcgenGymEnv
