"""One environment with the API of gymnasium.Env."""

from __future__ import annotations

import os
from typing import Any, SupportsFloat

import numpy as np

from procgen_client._requests import ACTION_COUNT
from procgen_client.client import Client
from procgen_client.envs._gymnasium import AutoresetMode, Env, single_spaces
from procgen_client.envs.vector_env import ProcgenVectorEnv
from procgen_client.errors import FailedPreconditionError, InvalidArgumentError
from procgen_client.tools.art import Art
from procgen_client.tools.server_process import ServerProcess


class _VectorEnvOfOne(ProcgenVectorEnv):
    _is_for_gymnasium = False


class ProcgenGymEnv(Env):
    """One environment on a server, with the contract of gymnasium.Env.

    A subclass of gymnasium.Env where Gymnasium is installed; works without it. Each step is a
    round trip: for many environments use ProcgenVectorEnv.

    Observations are uint8 [64, 64, 3], or of the format in the options; actions are integers in
    [0, 15). The time limit truncates an episode, every other end terminates it; reset must follow.
    Infos are numbers: ``level_seed``, ``prev_level_seed``, ``prev_level_complete``; at the end of
    an episode also ``episode_return`` and ``episode_length``; with record_episode_statistics
    ``episode``, a dict of numbers.

    Threads: one at a time.

    Attributes:
        vector_env: The ProcgenVectorEnv with one environment that steps it.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 15}

    def __init__(
        self,
        games: str,
        *,
        server: str | Client | ServerProcess | None = None,
        art: Art | None = None,
        render_mode: str | None = None,
        **options: Any,
    ) -> None:
        """Creates the environment.

        Args:
            games: The game's name.
            server, art, render_mode, options: As for ProcgenVectorEnv.

        Errors as ProcgenVectorEnv.
        """
        if not isinstance(games, str):
            raise InvalidArgumentError(f"games is {games!r}; one environment plays one game")
        self.vector_env = _VectorEnvOfOne(
            games,
            1,
            server=server,
            art=art,
            autoreset_mode=AutoresetMode.DISABLED,
            render_mode=render_mode,
            **options,
        )
        self.render_mode = render_mode
        self._is_over = False
        spaces = single_spaces(self.vector_env.pool.observation_shape, ACTION_COUNT)
        self.observation_space = spaces["observation_space"]
        self.action_space = spaces["action_space"]

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Starts a new episode.

        Args:
            seed: New seed of the choice of levels. None: unchanged; the first reset then returns
                the episode that rand_seed chose.
            options: ``level_seed``: the level to play.

        Returns:
            The first observation, and infos.
        """
        super().reset(seed=seed)
        level_seed = None if options is None else options.get("level_seed")
        observations, infos = self.vector_env.reset(
            seed=seed, options=None if level_seed is None else {"level_seeds": [level_seed]}
        )
        self._is_over = False
        return observations[0], _of_one(infos)

    def step(self, action: int) -> tuple[np.ndarray, SupportsFloat, bool, bool, dict[str, Any]]:
        """Steps with an action in [0, 15), or -1, which ends the episode.

        Returns:
            Observation, reward, terminated, truncated, infos.

        Raises:
            FailedPreconditionError: The episode is over: call reset.
            InvalidArgumentError: The action is out of range. Nothing was stepped.
        """
        if self._is_over:
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
        """Deletes the environment on the server. Closing again does nothing."""
        if hasattr(self, "vector_env"):  # False if __init__ failed.
            self.vector_env.close()


def _of_one(infos: dict[str, Any]) -> dict[str, Any]:
    """Returns the infos of the first environment of a vector environment."""
    return {
        name: values[0].item()
        if isinstance(values, np.ndarray)
        else {key: array[0].item() for key, array in values.items()}
        for name, values in infos.items()
        if not name.startswith("_") and infos[f"_{name}"][0]
    }
