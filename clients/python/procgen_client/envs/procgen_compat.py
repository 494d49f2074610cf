"""The API of Procgen 0.10.7 ("upstream"): a drop-in for the package `procgen`.

Replace ``from procgen import ...`` with ``from procgen_client import ...``. Levels, rewards and
episode ends equal upstream's for the same rand_seed.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from procgen_client import _checkpoint
from procgen_client._place import Server
from procgen_client._requests import ACTION_COUNT, ENV_COUNT_MAX, LEVEL_SEEDS, Reset, in_range
from procgen_client.batch import Batch
from procgen_client.catalog import catalog
from procgen_client.envs._gym3 import Gym3Env, action_type, observation_type
from procgen_client.envs._infos import level_dicts, terminal_infos
from procgen_client.envs._pools import check_render_mode
from procgen_client.errors import (
    FailedPreconditionError,
    InvalidArgumentError,
    UpstreamAssertionError,
)
from procgen_client.options import GAMES, EnvironmentOptions, check_names, keywords_of
from procgen_client.pool import Pool
from procgen_client.tools.art import Art

# The games, by upstream's name for the list.
ENV_NAMES = list(GAMES)

RENDER_SIZE_PX = 512


class ProcgenGym3Env(Gym3Env):
    """N environments with gym3's API: act, observe, get_info, callmethod.

    A subclass of gym3.Env, with its types, where gym3 is installed.

    Threads: one at a time.

    Attributes:
        num: Number of environments, N.
        ob_space, ac_space: Types of an observation, {"rgb": uint8 [64, 64, 3]}, and of an action.
        combos: Keys of each action, as get_combos returns them.
        options: Upstream's options by their names, with env_name, and with the rand_seed that was
            drawn if None was given. A dict.
        render_mode: "rgb_array" or None.
        pool: The Pool, for calls that this class does not have.
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
        debug: bool = False,
        resource_root: Art | None = None,
        art: Art | None = None,
        server: Server = None,
        **unknown: Any,
    ) -> None:
        """Makes the environments.

        Args:
            num, env_name: Number of environments, and their game. Or n games, separated by commas:
                environment i plays game i % n, and num is a multiple of n.
            center_agent, ..., rand_seed: As options.EnvironmentOptions.
            render_mode: "rgb_array": infos contain a frame for people, "rgb". Or None.
            num_threads: Threads that step: in this process at most so many, and one a core.
            debug: False, nothing is compiled.
            resource_root: Upstream's name of `art`.
            art, server: As for Pool.

        Raises:
            UnknownOptionError, UpstreamAssertionError: An argument is unknown or out of range.
            ProcgenError: As Pool.
        """
        check_names(type(self).__name__, unknown, keywords_of(ProcgenGym3Env.__init__))
        num = checked_num(type(self).__name__, num, env_name)
        check_render_mode(render_mode)
        _check(not debug, f"debug is {debug!r}; it is False, since nothing is compiled here")
        options = EnvironmentOptions(
            distribution_mode=distribution_mode,
            num_levels=num_levels,
            start_level=start_level,
            rand_seed=rand_seed,
            use_sequential_levels=bool(use_sequential_levels),
            center_agent=bool(center_agent),
            use_backgrounds=bool(use_backgrounds),
            use_generated_assets=bool(use_generated_assets),
            use_monochrome_assets=bool(use_monochrome_assets),
            restrict_themes=bool(restrict_themes),
            paint_vel_info=bool(paint_vel_info),
            debug_mode=debug_mode,
        )
        art = resource_root if art is None else art
        self.pool = _make_pool(env_name, num, server, art, num_threads, options)
        self.options: dict[str, Any] = {
            "env_name": env_name,
            **options,
            "rand_seed": self.pool.options["rand_seed"],
        }
        shape = observation_type(self.pool.observation_shape)
        super().__init__(ob_space=shape, ac_space=action_type(ACTION_COUNT), num=num)
        self.combos, self.render_mode = self.get_combos(), render_mode
        self._batch: Batch | None = None  # The current state; None: not received.

    def __getstate__(self) -> dict[str, Any]:
        """Supports pickle and copy, also between act and observe."""
        self._receive()
        return self.__dict__.copy()

    def act(self, ac: npt.ArrayLike) -> None:
        """Begins a step of all environments; observe waits for it.

        Args:
            ac: Numbers [N], each in [0, 15), or -1, which ends the episode. Cast to int32 as in
                upstream, so floats are truncated.

        Raises:
            InvalidArgumentError: A wrong length, or a value out of range. Nothing was stepped.
        """
        actions = _cast_actions(ac)
        _check(
            actions.shape == (self.num,), f"ac has shape {list(actions.shape)}; it is [{self.num}]"
        )
        self._receive()
        self._batch = None
        self.pool.send_step(actions, final_observations=True)

    def observe(self) -> tuple[np.ndarray, dict[str, np.ndarray], np.ndarray]:
        """Returns rewards, observations and first; also before the first act, and repeatedly.

        Returns:
            Rewards of the last act, float32 [N] (of the ended episode where one ended); {"rgb":
            uint8 [N, 64, 64, 3]}; whether a new episode has begun, bool [N]. The arrays belong to
            the caller.
        """
        batch = self._now()
        assert batch.observations is not None
        return batch.rewards.copy(), {"rgb": batch.observations.copy()}, batch.first.copy()

    def get_info(self) -> list[dict[str, Any]]:
        """Returns infos of each environment's level.

        Returns:
            A dict for each environment: ``prev_level_seed`` and ``prev_level_complete`` of the
            level that was stepped, ``level_seed`` of the level in the observation; with render_mode
            "rgb_array" also ``rgb``, uint8 [512, 512, 3].
        """
        infos = level_dicts(self._now())
        if self.render_mode is not None:
            pictures = self.pool.render(size_px=RENDER_SIZE_PX)
            for info, picture in zip(infos, pictures):
                info["rgb"] = picture
        return infos

    def terminal_infos(self) -> dict[int, dict[str, Any]]:
        """Returns infos of the episodes that the last act ended, by environment.

        ``terminal_observation`` is the last observation, {"rgb": uint8 [64, 64, 3]}, and
        ``TimeLimit.truncated`` whether the time limit ended the episode. Upstream has no such
        method.
        """
        return terminal_infos(self._now())

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
        result: list[Any] | None = methods[method](*args, **kwargs)
        return [None] * self.num if result is None else result

    def set_levels(self, level_seeds: Mapping[int, int]) -> None:
        """Starts a level at once in some environments; observe then returns their first frames.

        Upstream cannot do this: it plays the levels that rand_seed chooses. Their rewards are then
        0 and `first` is True. The others do not change.

        Args:
            level_seeds: Level seeds by environment.

        Raises:
            UpstreamAssertionError: There is no such environment, or a level seed is no int32.
        """
        try:
            resets = [
                Reset(
                    in_range("environment", environment, 0, self.num - 1),
                    in_range(f"level_seeds[{environment}]", level_seed, *LEVEL_SEEDS),
                )
                for environment, level_seed in level_seeds.items()
            ]
        except InvalidArgumentError as error:
            raise UpstreamAssertionError(error.message) from None
        self._receive()
        if resets:
            self._batch = self.pool.reset(resets)

    def get_state(self) -> list[bytes]:
        """Returns a snapshot of each environment."""
        self._receive()
        return self.pool.save_states()

    def set_state(self, states: Sequence[bytes]) -> None:
        """Restores each environment from a snapshot."""
        _check(
            len(states) == self.num,
            f"states has {len(states)} entries; there are {self.num} environments",
        )
        self._receive()
        self.pool.restore_states(states)
        self._batch = None

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a checkpoint, from which :meth:`load` continues bit for bit.

        A failure leaves the file as it was. Errors as ProcgenVectorEnv.save.
        """
        self._receive()
        _checkpoint.save(path, self.pool, _checkpoint.WrapperState(np.zeros(self.num, np.bool_)))

    def load(self, path: str | os.PathLike[str]) -> None:
        """Restores a checkpoint, whose state observe returns; errors as ProcgenVectorEnv.load."""
        self._receive()
        _checkpoint.load(path, self.pool)
        self._batch = None

    def get_combos(self) -> list[tuple[str, ...]]:
        """Returns the keys of each action."""
        return [tuple(action["keys"]) for action in catalog()["actions"]]

    def keys_to_act(self, keys_list: Sequence[Sequence[str]]) -> list[np.ndarray]:
        """Returns the actions of pressed keys, for interactive programs.

        Args:
            keys_list: Names of the pressed keys, for each environment.

        Returns:
            For each environment int64 [1]: the action with the most of these keys and no others.
        """
        actions = []
        for keys in keys_list:
            pressed = [set(combo) <= set(keys) for combo in self.combos]
            lengths = [len(c) if p else -1 for c, p in zip(self.combos, pressed)]
            actions.append(np.array([int(np.argmax(lengths))]))
        return actions

    def close(self) -> None:
        """Closes the environments. Closing again does nothing."""
        self.pool.close()

    def _receive(self) -> None:
        """Waits for the step that act began, if there is one.

        Raises:
            FailedPreconditionError: The environments are closed.
        """
        if self.pool.closed:
            raise FailedPreconditionError("the environments are closed: make others")
        if self.pool.in_flight:
            self._batch = self.pool.receive()

    def _now(self) -> Batch:
        self._receive()
        if self._batch is None:
            self._batch = self.pool.observe()
        return self._batch


def checked_num(owner: str, num: object, env_name: object, name: str = "num") -> int:
    """Returns the number of environments, after checks of its type and that of their game.

    Raises:
        UpstreamAssertionError: It is no positive integer, or env_name is no text.
    """
    if isinstance(num, str):
        raise UpstreamAssertionError(
            f"{name} is {num!r} and env_name is {env_name!r}; the number of environments comes "
            f"first: {owner}({env_name!r}, {num!r})"
        )
    _check(
        isinstance(env_name, str),
        f"env_name is {env_name!r}; it is the name of a game, or several, separated by commas",
    )
    try:
        return in_range(name, num, 1, ENV_COUNT_MAX)
    except InvalidArgumentError as error:
        raise UpstreamAssertionError(error.message) from None


def _make_pool(
    env_name: str,
    num: int,
    server: Server,
    art: Art | None,
    num_threads: int,
    options: EnvironmentOptions,
) -> Pool:
    games = env_name.split(",")
    _check(
        num % len(games) == 0,
        f"num is {num}; it is a multiple of {len(games)}, the number of games in {env_name!r}",
    )
    threads = num_threads if num_threads < (os.cpu_count() or 1) else None
    try:
        return Pool(games, num, server=server, art=art, num_threads=threads, **options)
    except InvalidArgumentError as error:
        raise UpstreamAssertionError(error.message) from None


def _check(holds: bool, message: str) -> None:
    if not holds:
        raise UpstreamAssertionError(message)


def _cast_actions(ac: npt.ArrayLike) -> np.ndarray:
    """Casts actions to int32, as upstream does.

    Raises:
        UpstreamAssertionError: They are not finite numbers.
    """
    given = np.asarray(ac)
    try:
        if given.dtype.kind == "f" and not np.isfinite(given).all():
            raise ValueError("not all are finite")
        with np.errstate(invalid="ignore"):  # Values beyond int32 become invalid actions.
            return given.astype(np.int32)
    except (TypeError, ValueError, OverflowError) as error:
        raise UpstreamAssertionError(
            f"ac has type {given.dtype}; it contains finite numbers ({error})"
        ) from None
