"""PufferLib's PufferEnv, over a pool."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pufferlib
from gymnasium import spaces

from procgen_client._place import Server
from procgen_client._requests import ACTION_COUNT, Reset
from procgen_client.batch import Batch
from procgen_client.options import PoolOptions, check_names
from procgen_client.pool import Pool, option_names
from procgen_client.tools.art import Art

if TYPE_CHECKING:
    from typing_extensions import Unpack


class ProcgenPufferEnv(pufferlib.PufferEnv):
    """N environments as N agents, whose observations are drawn in PufferLib's own memory.

    As of PufferLib 3, infos are those of ended episodes: ``episode_return``, ``episode_length``,
    ``level_seed``. Threads: one at a time.

    Attributes:
        pool: The Pool.
    """

    def __init__(
        self,
        games: str | Sequence[str],
        num_envs: int = 64,
        *,
        buf: Any = None,  # noqa: ANN401
        seed: int | None = None,
        server: Server = None,
        art: Art | None = None,
        **options: Unpack[PoolOptions],
    ) -> None:
        """Makes the environments.

        Args:
            games, num_envs, server, art, options: As Pool.
            buf, seed: PufferLib's arrays, and its seed: environment i of this object chooses its
                levels by seed + i, as with ``reset(seed)``.

        Errors as Pool.
        """
        check_names(type(self).__name__, options, option_names() - {"autoreset_mode"})
        self.pool = Pool(games, num_envs, server=server, art=art, **options)
        self.num_agents = num_envs
        self.single_observation_space = spaces.Box(0, 255, self.pool.observation_shape, np.uint8)
        self.single_action_space = spaces.Discrete(ACTION_COUNT)
        self._seed = seed
        super().__init__(buf)

    def reset(self, seed: int | None = None) -> tuple[np.ndarray, list[dict[str, Any]]]:
        """Starts new episodes; the seed of the choice of levels of environment i is seed + i."""
        seed, self._seed = (self._seed if seed is None else seed), None
        seeds = [None if seed is None else seed + i for i in range(self.num_agents)]
        batch = self.pool.reset(
            [Reset(i, rand_seed=each) for i, each in enumerate(seeds)], out=self.observations
        )
        self._keep(batch)
        return self.observations, []

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Steps with actions int [N]; a following episode starts in the same step."""
        batch = self.pool.step(actions, out=self.observations)
        self._keep(batch)
        infos = [
            {
                "episode_return": float(batch.episode_returns[row]),
                "episode_length": int(batch.episode_lengths[row]),
                "level_seed": int(batch.prev_level_seeds[row]),
            }
            for row in np.flatnonzero(batch.ended)
        ]
        return self.observations, self.rewards, self.terminals, self.truncations, infos

    def close(self) -> None:
        """Closes the pool. Closing again does nothing."""
        self.pool.close()

    def _keep(self, batch: Batch) -> None:
        self.rewards[:], self.terminals[:] = batch.rewards, batch.terminated
        self.truncations[:] = batch.truncated
