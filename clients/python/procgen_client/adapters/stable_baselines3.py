"""Stable-Baselines3's VecEnv, over a pool."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from gymnasium import spaces
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import VecEnv

from procgen_client._place import Server
from procgen_client._requests import ACTION_COUNT, Reset
from procgen_client.batch import Batch
from procgen_client.envs._infos import level_dicts
from procgen_client.envs._pools import check_render_mode
from procgen_client.errors import UnimplementedError
from procgen_client.options import PoolOptions, check_names
from procgen_client.pool import Pool, option_names
from procgen_client.tools.art import Art

if TYPE_CHECKING:
    from typing_extensions import Unpack


class ProcgenVecEnv(VecEnv):
    """N environments of one pool, for ``PPO("CnnPolicy", ProcgenVecEnv("coinrun", 64))``.

    Observations are uint8 [N, channels * frame_stack, 64, 64], the oldest frame first, as CnnPolicy
    takes them: neither VecTransposeImage nor VecFrameStack is needed. Infos are upstream's and,
    where an episode ended, ``terminal_observation``, ``TimeLimit.truncated`` and ``episode``, that
    of VecMonitor. An option of reset is ``level_seed``. Threads: one at a time.

    Attributes:
        pool: The Pool.
    """

    def __init__(
        self,
        games: str | Sequence[str],
        num_envs: int = 64,
        *,
        server: Server = None,
        art: Art | None = None,
        render_mode: str | None = None,
        **options: Unpack[PoolOptions],
    ) -> None:
        """Makes the environments.

        Args:
            games, num_envs, server, art, options: As Pool; layout is "chw".
            render_mode: "rgb_array" for render and get_images, or None.

        Errors as Pool.
        """
        check_names(type(self).__name__, options, option_names() - {"autoreset_mode", "layout"})
        check_render_mode(render_mode)
        self.render_mode = render_mode
        options["layout"] = "chw"
        self.pool = Pool(games, num_envs, server=server, art=art, **options)
        *_, channels, height, width = self.pool.observation_shape
        self._shape = (channels * options.get("frame_stack", 1), height, width)
        self._untouched = True
        self._begin_times = np.full(num_envs, time.perf_counter())
        super().__init__(
            num_envs, spaces.Box(0, 255, self._shape, np.uint8), spaces.Discrete(ACTION_COUNT)
        )

    def reset(self) -> np.ndarray:
        """Starts new episodes and returns their first observations.

        Seeds of ``seed`` and options of ``set_options`` apply once. Without them the first reset
        returns the levels of rand_seed.
        """
        for options in self._options:
            check_names("reset", options, ("level_seed",))
        levels = [options.get("level_seed") for options in self._options]
        resets = [Reset(i, *arguments) for i, arguments in enumerate(zip(levels, self._seeds))]
        if self._untouched and not any(self._options) and self._seeds == [None] * self.num_envs:
            batch = self.pool.observe()
        else:
            batch = self.pool.reset(resets)
        self._untouched = False
        self._reset_seeds()
        self._reset_options()
        self._begin_times[:] = time.perf_counter()
        self.reset_infos = level_dicts(batch)
        return self._observations_of(batch.observations)

    def step_async(self, actions: np.ndarray) -> None:
        """Begins a step: actions int [N]."""
        self.pool.send_step(actions, final_observations=True)
        self._untouched = False

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Returns observations, rewards float32 [N], dones bool [N] and infos."""
        batch = self.pool.receive()
        infos = level_dicts(batch)
        ended = batch.ended
        if ended.any():
            now = time.perf_counter()
            for row in np.flatnonzero(ended):
                infos[row] |= self._episode_of(batch, row, now - self._begin_times[row])
            self._begin_times[ended] = now
        return self._observations_of(batch.observations), batch.rewards.copy(), ended, infos

    def close(self) -> None:
        """Closes the pool. Closing again does nothing."""
        self.pool.close()

    def get_images(self) -> Sequence[np.ndarray | None]:
        """Renders all environments, uint8 [512, 512, 3] each; None without render_mode."""
        if self.render_mode is None:
            return [None] * self.num_envs
        return self.pool.render(size_px=512)

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:  # noqa: ANN401
        """Returns an attribute of this object for each environment."""
        return [getattr(self, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:  # noqa: ANN401
        """Sets an attribute of this object; `indices` has no effect."""
        setattr(self, attr_name, value)

    def env_method(
        self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any
    ) -> list[Any]:
        """Raises UnimplementedError: there are no objects of single environments."""
        raise UnimplementedError(f"no environment has a method {method_name!r}; use `pool`")

    def env_is_wrapped(
        self, wrapper_class: type, indices: None | int | Iterable[int] = None
    ) -> list[bool]:
        """Returns True for Monitor, whose info `episode` the environments have."""
        return [wrapper_class is Monitor for _ in self._get_indices(indices)]

    def _observations_of(self, frames: np.ndarray) -> np.ndarray:
        return frames.reshape(len(frames), *self._shape)

    def _episode_of(self, batch: Batch, row: int, seconds: float) -> dict[str, Any]:
        assert batch.final_observations is not None
        return {
            "terminal_observation": batch.final_observations[row].reshape(self._shape).copy(),
            "TimeLimit.truncated": bool(batch.truncated[row]),
            "episode": {
                "r": float(batch.episode_returns[row]),
                "l": int(batch.episode_lengths[row]),
                "t": round(seconds, 6),
            },
        }
