"""The interfaces of the released benchmark's package, for programs that are written to them.

``from procgen_client import ProcgenGym3Env, ProcgenEnv`` in place of the released import is all
that such a program needs: without an address a server of its own is started, with which it shares
memory. Levels, rewards and ends are those of the released package for the same rand_seed.
"""

from __future__ import annotations

import warnings
import weakref
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from procgen_client._gym3 import Gym3Env, action_type, observation_type
from procgen_client._gymnasium import spaces
from procgen_client._requests import ACTION_COUNT
from procgen_client.batch import Batch
from procgen_client.client import Client
from procgen_client.errors import InvalidArgumentError
from procgen_client.pool import Pool
from procgen_client.private_server import is_private, open_client

_RENDER_MODES = (None, "rgb_array")
_RENDER_SIDE_PX = 512


class ProcgenGym3Env(Gym3Env):
    """N environments with gym3's interface: act, observe, get_info, callmethod.

    A subclass of gym3.Env, with its types, where gym3 is installed.

    Threads: one at a time.

    Attributes:
        num: Number of environments, N.
        ob_space, ac_space: Types of an observation, {"rgb": uint8 [64, 64, 3]}, and of an action.
        pool: The pool on the server.
    """

    def __init__(
        self,
        num: int,
        env_name: str,
        center_agent: bool = True,
        use_backgrounds: bool = True,
        use_monochrome_assets: bool = False,
        restrict_themes: bool = False,
        use_generated_assets: bool = False,
        paint_vel_info: bool = False,
        distribution_mode: str = "hard",
        num_levels: int = 0,
        start_level: int = 0,
        use_sequential_levels: bool = False,
        debug_mode: int = 0,
        rand_seed: int | None = None,
        num_threads: int = 4,
        render_mode: str | None = None,
        *,
        server: str | Client | None = None,
    ) -> None:
        """Makes the environments.

        Args:
            num, env_name: Number of environments, and the name of their game.
            center_agent, ..., rand_seed: The released options, as
                procgen_client.options.EnvironmentOptions tells.
            num_threads: Not used: the server has workers of its own.
            render_mode: "rgb_array": infos have a picture for people, "rgb". Or None.
            server: As ProcgenVectorEnv takes it.

        Errors as Client and Client.create_pool.
        """
        if render_mode not in _RENDER_MODES:
            raise InvalidArgumentError(f"render_mode is {render_mode!r}; it is None or 'rgb_array'")
        client = open_client(server)
        try:
            self.pool = client.create_pool(
                env_name,
                num,
                transport="shared_memory" if is_private(client) else "stream",
                distribution_mode=distribution_mode,
                num_levels=num_levels,
                start_level=start_level,
                rand_seed=rand_seed,
                use_sequential_levels=use_sequential_levels,
                center_agent=center_agent,
                use_backgrounds=use_backgrounds,
                use_generated_assets=use_generated_assets,
                use_monochrome_assets=use_monochrome_assets,
                restrict_themes=restrict_themes,
                paint_vel_info=paint_vel_info,
                debug_mode=debug_mode,
            )
        except BaseException:
            if client is not server:
                client.close()
            raise
        super().__init__(
            ob_space=observation_type(self.pool.observation_shape),
            ac_space=action_type(ACTION_COUNT),
            num=num,
        )
        self._actions = client.catalog().actions
        self._is_rendered = render_mode is not None
        self._batch: Batch | None = None  # As the environments stand, once it is known.
        self._close_once = weakref.finalize(
            self, _close, self.pool, None if client is server else client
        )

    def act(self, ac: npt.ArrayLike) -> None:
        """Has all environments stepped, and does not wait for it; observe does.

        Args:
            ac: int [N], each in [0, 15), or -1, which ends the episode.

        Raises:
            InvalidArgumentError: A wrong length, or a value out of range. Nothing has moved.
        """
        actions = np.asarray(ac)
        if actions.shape != (self.num,):
            raise InvalidArgumentError(f"ac has shape {list(actions.shape)}; it is [{self.num}]")
        self._receive()
        self._batch = None
        self.pool.send_step(actions)

    def observe(self) -> tuple[np.ndarray, dict[str, np.ndarray], np.ndarray]:
        """Tells how the environments stand; also before the first act, and again.

        Returns:
            Reward of the last act, float32 [N] (the old episode's where one ended); {"rgb": uint8
            [N, 64, 64, 3]}; whether a new episode has begun, bool [N]. All are the caller's own.
        """
        batch = self._now()
        assert batch.observations is not None
        return batch.rewards.copy(), {"rgb": batch.observations.copy()}, batch.first.copy()

    def get_info(self) -> list[dict[str, Any]]:
        """Tells of each environment's level.

        Returns:
            A dict for each: ``prev_level_seed`` and ``prev_level_complete`` of the level that was
            stepped, ``level_seed`` of the one in the observation; with render_mode "rgb_array" also
            ``rgb``, uint8 [512, 512, 3].
        """
        batch = self._now()
        complete = batch.prev_level_complete.astype(np.uint8)
        infos: list[dict[str, Any]] = [
            {"prev_level_seed": previous, "prev_level_complete": is_complete, "level_seed": seed}
            for previous, is_complete, seed in zip(
                batch.prev_level_seeds, complete, batch.level_seeds, strict=True
            )
        ]
        if self._is_rendered:
            pictures = self.pool.render(side_px=_RENDER_SIDE_PX)
            for info, picture in zip(infos, pictures, strict=True):
                info["rgb"] = picture
        return infos

    def callmethod(self, method: str, *args: Sequence[Any], **kwargs: Sequence[Any]) -> list[Any]:
        """Calls a method of each environment: "get_state", or "set_state" with a list of states.

        Raises:
            InvalidArgumentError: There is no such method, or `states` has a wrong length.
        """
        methods: dict[str, Callable[..., Any]] = {
            "get_state": self.get_state,
            "set_state": self.set_state,
        }
        if method not in methods:
            raise InvalidArgumentError(f"method is {method!r}; it is one of {', '.join(methods)}")
        result = methods[method](*args, **kwargs)
        return [None] * self.num if result is None else result

    def get_state(self) -> list[bytes]:
        """Takes a snapshot of each environment."""
        self._receive()
        return self.pool.save_states()

    def set_state(self, states: Sequence[bytes]) -> None:
        """Puts each environment into a snapshot."""
        self._receive()
        self.pool.restore_states(states)
        self._batch = None

    def get_combos(self) -> list[tuple[str, ...]]:
        """Tells which keys each action presses."""
        return [tuple(action.keys) for action in self._actions]

    def close(self) -> None:
        """Deletes the environments. Closing again does nothing."""
        self._close_once()

    def _receive(self) -> None:
        if self.pool.in_flight:
            self._batch = self.pool.receive()

    def _now(self) -> Batch:
        self._receive()
        if self._batch is None:
            self._batch = self.pool.observe()
        return self._batch


class ProcgenEnv:
    """N environments with the interface of baselines' VecEnv: reset, step.

    Threads: one at a time.

    Attributes:
        num_envs: Number of environments, N.
        observation_space, action_space: Spaces of Gymnasium, or classes like them without it:
            Dict with "rgb", and Discrete.
        env: The ProcgenGym3Env that it is made of.
    """

    metadata: dict[str, Any] = {"render.modes": ["rgb_array"]}
    reward_range = (-np.inf, np.inf)
    spec = None

    def __init__(self, num_envs: int, env_name: str, *args: Any, **kwargs: Any) -> None:
        """Makes the environments; the arguments are ProcgenGym3Env's."""
        self.env = ProcgenGym3Env(num_envs, env_name, *args, **kwargs)
        self.num_envs = num_envs
        shape = self.env.pool.observation_shape
        self.observation_space = spaces.Dict({"rgb": spaces.Box(0, 255, shape, np.uint8)})
        self.action_space = spaces.Discrete(ACTION_COUNT)

    @property
    def unwrapped(self) -> ProcgenEnv:
        """The environments themselves: nothing wraps them."""
        return self

    def reset(self) -> dict[str, np.ndarray]:
        """Gives the observations, {"rgb": uint8 [N, 64, 64, 3]}, and begins no new episodes.

        As with the released package, episodes end by the game's rules alone. A call in their midst
        is warned of.
        """
        _, observations, first = self.env.observe()
        if not first.all():
            warnings.warn(
                "reset in the midst of episodes does nothing: they end by the game's rules",
                stacklevel=2,
            )
        return observations

    def step(
        self, actions: npt.ArrayLike
    ) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Steps all environments.

        Args:
            actions: int [N], each in [0, 15), or -1.

        Returns:
            Observations {"rgb": uint8 [N, 64, 64, 3]}, of the next episode where one has ended;
            rewards, float32 [N]; whether an episode has ended, bool [N]; a list of infos.

        Raises:
            InvalidArgumentError: `actions` has a wrong length or a value out of range.
        """
        self.step_async(actions)
        return self.step_wait()

    def step_async(self, actions: npt.ArrayLike) -> None:
        """The first half of step: what is done before the other costs no time."""
        self.env.act(actions)

    def step_wait(
        self,
    ) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Waits for what step_async began, and gives what step gives."""
        rewards, observations, first = self.env.observe()
        return observations, rewards, first, self.env.get_info()

    def render(self, mode: str = "rgb_array") -> np.ndarray:
        """Draws all environments for people, side by side: uint8 [512, N * 512, 3]."""
        if mode != "rgb_array":
            raise InvalidArgumentError(f"mode is {mode!r}; it is 'rgb_array'")
        return np.concatenate(self.get_images(), axis=1)

    def get_images(self) -> list[np.ndarray]:
        """Draws all environments for people: N pictures, uint8 [512, 512, 3]."""
        return self.env.pool.render(side_px=_RENDER_SIDE_PX)

    def close(self) -> None:
        """Deletes the environments. Closing again does nothing."""
        self.env.close()


def _close(pool: Pool, client: Client | None) -> None:
    pool.close()
    if client is not None:
        client.close()
