"""What upstream's interface takes from Gym, Gymnasium's predecessor, where that is installed."""

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
    """Gives the module whose spaces the program checks against.

    Upstream's are Gym's: so they are if the program has imported Gym. A program that has not can
    only check against Gymnasium's.
    """
    gym = sys.modules.get("gym")
    return spaces if gym is None else gym.spaces


def make_env(
    env_name: str, render_mode: str | None = None, render: bool = False, **options: Any
) -> Any:  # noqa: ANN401 - gym.Env, which may not be installed
    """Makes one environment with the interface of Gym until 0.21, as upstream's Gym ids do.

    Args:
        env_name: The game.
        render_mode: "rgb_array", or None.
        render: False. Upstream opens a window otherwise.
        **options: As ProcgenGym3Env takes them.

    Raises:
        InvalidArgumentError: A window is asked for.
        ProcgenError: As ProcgenGym3Env.
    """
    if render or render_mode == "human":
        raise InvalidArgumentError(
            "render_mode is 'human'; no window is opened here: it is None or 'rgb_array'"
        )
    return _env_class()(env_name, render_mode=render_mode, **options)


def register_environments() -> None:
    """Registers upstream's ids, ``procgen-coinrun-v0``, with Gym, if the program has imported it.

    Where the package `procgen` is installed the ids are its own.
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

    from procgen_client.envs.procgen_compat import ProcgenEnv

    class ProcgenGymEnv(gym.Env):
        """One environment: reset gives an observation, step four values.

        As upstream's, an episode ends by the game's rules alone: reset within an episode and seed
        do nothing but warn. The observation of the step that ends an episode is the one before it.
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
            warnings.warn("seed does nothing: give rand_seed to gym.make", stacklevel=2)

        def close(self) -> None:
            if hasattr(self, "venv"):  # It is not where __init__ failed.
                self.venv.close()

    return ProcgenGymEnv
