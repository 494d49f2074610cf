"""The API of baselines' VecEnv, as in Procgen 0.10.7 ("upstream")."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from procgen_client._requests import ACTION_COUNT
from procgen_client.envs._gym import program_spaces
from procgen_client.envs._gym3 import to_baselines_vec_env
from procgen_client.envs.procgen_compat import RENDER_SIZE_PX, ProcgenGym3Env, checked_num
from procgen_client.errors import InvalidArgumentError
from procgen_client.options import check_names, keywords_of


class BaselinesVecEnv:
    """A ProcgenGym3Env with the API of baselines' VecEnv: reset, step.

    Threads: one at a time.

    Attributes:
        num_envs: Number of environments, N.
        observation_space, action_space: Dict with "rgb", and Discrete: spaces of Gym, if the
            program has imported it, else of Gymnasium, or classes like them without it.
        render_mode: "rgb_array" or None.
        env: The ProcgenGym3Env that steps them.
    """

    # Keys of Gym until 0.21, as in upstream, and of later versions.
    metadata: dict[str, Any] = {
        "render.modes": ["human", "rgb_array"],
        "video.frames_per_second": 15,
        "render_modes": ["human", "rgb_array"],
        "render_fps": 15,
    }
    reward_range = (-np.inf, np.inf)
    spec = None

    def __init__(self, env: ProcgenGym3Env) -> None:
        """Takes the environment; close closes it."""
        self.env = env
        self.num_envs = env.num
        self.render_mode = env.render_mode
        spaces = program_spaces()
        shape = env.pool.observation_shape
        self.observation_space = spaces.Dict({"rgb": spaces.Box(0, 255, shape, np.uint8)})
        self.action_space = spaces.Discrete(ACTION_COUNT)

    @property
    def unwrapped(self) -> BaselinesVecEnv:
        """The environment itself, since it is not a wrapper."""
        return self

    def reset(self) -> dict[str, np.ndarray]:
        """Returns the observations, {"rgb": uint8 [N, 64, 64, 3]}, and starts no episodes.

        As in upstream, only the game ends an episode. A call within an episode warns.
        """
        _, observations, first = self.env.observe()
        if not first.all():
            warnings.warn(
                "reset within an episode does nothing: only the game ends an episode",
                stacklevel=2,
            )
        return observations

    def step(
        self, actions: npt.ArrayLike
    ) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Steps all environments.

        Args:
            actions: Numbers [N], each in [0, 15), or -1, as ProcgenGym3Env.act takes them.

        Returns:
            Observations {"rgb": uint8 [N, 64, 64, 3]}, of the next episode where one ended;
            rewards, float32 [N]; whether an episode ended, bool [N]; a list of infos. Beside
            upstream's infos, those of an environment whose episode ended have its last observation,
            ``terminal_observation``, and ``TimeLimit.truncated``, as of Stable-Baselines3.

        Raises:
            InvalidArgumentError: `actions` has a wrong length or a value out of range.
        """
        self.step_async(actions)
        return self.step_wait()

    def step_async(self, actions: npt.ArrayLike) -> None:
        """Begins a step; step_wait returns its results."""
        self.env.act(actions)

    def step_wait(
        self,
    ) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Waits for the step that step_async began, and returns the values of step."""
        rewards, observations, first = self.env.observe()
        infos = self.env.get_info()
        for environment, terminal in self.env.terminal_infos().items():
            infos[environment] |= terminal
        return observations, rewards, first, infos

    def render(self, mode: str = "human") -> np.ndarray | None:
        """Returns a frame of environment 0, as upstream does; get_images returns all.

        Args:
            mode: "rgb_array": the frame in the infos, uint8 [512, 512, 3], if render_mode is
                "rgb_array"; else the observation, uint8 [64, 64, 3]. "human": returns None, since
                no window is opened.

        Raises:
            InvalidArgumentError: There is no such mode.
        """
        if mode not in self.metadata["render_modes"]:
            raise InvalidArgumentError(f"mode is {mode!r}; it is 'human' or 'rgb_array'")
        if mode == "human":
            return None
        if self.render_mode is None:
            observation: np.ndarray = self.env.observe()[1]["rgb"][0]
            return observation
        return self.env.pool.render([0], size_px=RENDER_SIZE_PX)[0]

    def set_levels(self, level_seeds: Mapping[int, int]) -> dict[str, np.ndarray]:
        """Starts a level at once in some environments, as ProcgenGym3Env.set_levels.

        Returns:
            The observations of all.
        """
        self.env.set_levels(level_seeds)
        return self.observe()

    def observe(self) -> dict[str, np.ndarray]:
        """Returns the current observations, as the last step or set_levels left them."""
        observations: dict[str, np.ndarray] = self.env.observe()[1]
        return observations

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a checkpoint; as ProcgenGym3Env.save."""
        self.env.save(path)

    def load(self, path: str | os.PathLike[str]) -> dict[str, np.ndarray]:
        """Restores a checkpoint and returns the observations. Errors as ProcgenVectorEnv.load."""
        self.env.load(path)
        return self.observe()

    def get_images(self) -> list[np.ndarray]:
        """Renders all environments for people: N frames, uint8 [512, 512, 3]."""
        return self.env.pool.render(size_px=RENDER_SIZE_PX)

    def close(self) -> None:
        """Closes the environments. Closing again does nothing."""
        self.env.close()


class ProcgenEnv(BaselinesVecEnv):
    """N environments with the API of baselines' VecEnv: reset, step.

    Threads: one at a time.
    """

    def __init__(self, num_envs: int, env_name: str, *args: Any, **kwargs: Any) -> None:
        """Creates the environments; arguments and errors as for ProcgenGym3Env."""
        owner = type(self).__name__
        check_names(owner, kwargs, keywords_of(ProcgenGym3Env.__init__) - {"num"} | {"num_envs"})
        num_envs = checked_num(owner, num_envs, env_name, "num_envs")
        super().__init__(ProcgenGym3Env(num_envs, env_name, *args, **kwargs))


# gym3's class where gym3 and Gym are installed: it also takes gym3's wrappers.
ToBaselinesVecEnv: Any = to_baselines_vec_env() or BaselinesVecEnv
