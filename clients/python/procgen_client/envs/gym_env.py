"""One environment with the API of gymnasium.Env."""

from __future__ import annotations

import copy
import os
from typing import TYPE_CHECKING, Any, SupportsFloat

import numpy as np

from procgen_client._place import Server
from procgen_client._requests import ACTION_COUNT
from procgen_client.envs._gymnasium import AutoresetMode, Env, single_spaces
from procgen_client.envs._pools import time_limit_steps
from procgen_client.envs._reset_arguments import reset_options_of
from procgen_client.envs.vector_env import ProcgenVectorEnv, option_names
from procgen_client.errors import FailedPreconditionError, InvalidArgumentError
from procgen_client.objects import Objects
from procgen_client.options import PoolOptions, check_names
from procgen_client.tools.art import Art

if TYPE_CHECKING:
    from typing_extensions import Unpack


class ProcgenGymEnv(Env):
    """One environment with the contract of gymnasium.Env, in this process or on a server.

    A subclass of gymnasium.Env where Gymnasium is installed; works without it. For many
    environments use ProcgenVectorEnv.

    Observations are uint8 [64, 64, 3], or of the format in the options; actions are integers in
    [0, 15). The time limit truncates an episode, every other end terminates it; reset must follow.
    Infos are numbers: ``level_seed``, ``prev_level_seed``, ``prev_level_complete``; at the end of
    an episode also ``episode_return`` and ``episode_length``.

    Threads: one at a time.

    Attributes:
        vector_env: The ProcgenVectorEnv with one environment that steps it.
        env: The same, for programs that look for upstream's get_info in ``env.env``.
        spec: Gymnasium's EnvSpec, if gymnasium.make made it. Its max_episode_steps is the game's
            time limit, and no wrapper TimeLimit is needed.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 15}
    _spec: Any = None

    def __init__(
        self,
        games: str,
        *,
        server: Server = None,
        art: Art | None = None,
        render_mode: str | None = None,
        render_size_px: int = 512,
        frame_skip: int = 1,
        **options: Unpack[PoolOptions],
    ) -> None:
        """Makes the environment.

        Args:
            games: The game's name.
            server, art, render_mode, render_size_px, frame_skip, options: As for ProcgenVectorEnv.

        Errors as ProcgenVectorEnv.
        """
        if not isinstance(games, str):
            raise InvalidArgumentError(f"games is {games!r}; one environment plays one game")
        check_names(type(self).__name__, options, option_names() - {"num_envs", "autoreset_mode"})
        self.vector_env = ProcgenVectorEnv(
            games,
            1,
            server=server,
            art=art,
            autoreset_mode=AutoresetMode.DISABLED,
            render_mode=render_mode,
            render_size_px=render_size_px,
            frame_skip=frame_skip,
            **options,
        )
        self.env = self.vector_env
        self.render_mode = render_mode
        self._is_over = False
        spaces = single_spaces(self.vector_env.pool.observation_shape, ACTION_COUNT)
        self.observation_space = spaces["observation_space"]
        self.action_space = spaces["action_space"]

    @property
    def spec(self) -> Any:  # noqa: ANN401 - gymnasium.envs.registration.EnvSpec, or None
        """What gymnasium.make assigned, with the game's time limit; or None."""
        return self._spec

    @spec.setter
    def spec(self, given: Any) -> None:  # noqa: ANN401
        self._spec = copy.copy(given)
        if getattr(given, "max_episode_steps", 0) is None:
            steps, skipped = time_limit_steps(self.vector_env.pool), self.vector_env._frame_skip
            self._spec.max_episode_steps = -(-steps // skipped)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Starts a new episode.

        Args:
            seed: New seed of the choice of levels. None: unchanged; the first reset then returns
                the episode that rand_seed chose.
            options: ``level_seed``, or ``level_seeds``: the level to play.

        Returns:
            The first observation, and infos.

        Raises:
            InvalidArgumentError: `seed` is out of range, or an option is unknown or malformed.
            FailedPreconditionError: The environment is closed.
        """
        _, levels = reset_options_of(options, 1, type(self).__name__, is_single=True)
        level = {} if levels[0] is None else {"level_seed": levels[0]}
        observations, infos = self.vector_env.reset(seed=seed, options=level)
        super().reset(seed=seed)
        self._is_over = False
        return observations[0], _of_one(infos)

    def step(self, action: int) -> tuple[np.ndarray, SupportsFloat, bool, bool, dict[str, Any]]:
        """Steps with an action in [0, 15), or -1, which ends the episode.

        Returns:
            Observation, reward, terminated, truncated, infos.

        Raises:
            FailedPreconditionError: The episode is over: call reset. Or the environment is closed.
            InvalidArgumentError: The action is out of range. Nothing was stepped.
        """
        if self._is_over and not self.vector_env.closed:
            raise FailedPreconditionError("the episode is over: call reset")
        observations, rewards, terminated, truncated, infos = self.vector_env.step([action])
        self._is_over = bool(terminated[0] or truncated[0])
        return (
            observations[0],
            float(rewards[0]),
            bool(terminated[0]),
            bool(truncated[0]),
            _of_one(infos),
        )

    def save_state(self) -> bytes:
        """Returns a snapshot, for any environment of the same game."""
        return self.vector_env.save_states()[0]

    def restore_state(self, state: bytes) -> tuple[np.ndarray, dict[str, Any]]:
        """Restores a saved state and returns observation and info, as reset does."""
        observations, infos = self.vector_env.restore_states([state])
        self._is_over = bool(self.vector_env.episodes_over[0])
        return observations[0], _of_one(infos)

    def objects(self, objects_max: int = 64) -> Objects:
        """Returns the objects of the environment as arrays of N = 1; see Pool.objects."""
        return self.vector_env.objects(objects_max)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a checkpoint; as ProcgenVectorEnv.save."""
        self.vector_env.save(path)

    def load(self, path: str | os.PathLike[str]) -> tuple[np.ndarray, dict[str, Any]]:
        """Restores a checkpoint and returns observation and info, as reset does.

        Errors as ProcgenVectorEnv.load.
        """
        observations, infos = self.vector_env.load(path)
        self._is_over = bool(self.vector_env.episodes_over[0])
        return observations[0], _of_one(infos)

    def render(self) -> np.ndarray | None:
        """Renders for people: uint8 [side, side, 3]. None if render_mode is None."""
        frames = self.vector_env.render()
        return None if frames is None else frames[0]

    def close(self) -> None:
        """Closes the environment. Closing again does nothing."""
        if hasattr(self, "vector_env"):  # False if __init__ failed.
            self.vector_env.close()


def _of_one(infos: dict[str, Any]) -> dict[str, Any]:
    """Returns the infos of the first environment of a vector environment."""
    return {
        name: values[0].item()
        for name, values in infos.items()
        if not name.startswith("_") and infos[f"_{name}"][0]
    }
