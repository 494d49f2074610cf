"""dm_env's Environment, over a pool of one environment."""

from __future__ import annotations

from typing import TYPE_CHECKING

import dm_env
import numpy as np
from dm_env import specs

from procgen_client._place import Server
from procgen_client._requests import ACTION_COUNT, Reset
from procgen_client.batch import Batch
from procgen_client.options import PoolOptions, check_names
from procgen_client.pool import Pool, option_names
from procgen_client.tools.art import Art

if TYPE_CHECKING:
    from typing_extensions import Unpack


class ProcgenDmEnv(dm_env.Environment):
    """One environment. Observations are uint8 [64, 64, 3], actions in [0, 15).

    The discount of a last step is 1 if the time limit ended the episode, else 0. Threads: one at a
    time.

    Attributes:
        pool: The Pool.
    """

    def __init__(
        self,
        game: str,
        *,
        server: Server = None,
        art: Art | None = None,
        **options: Unpack[PoolOptions],
    ) -> None:
        """Makes the environment; arguments and errors as Pool."""
        check_names(type(self).__name__, options, option_names() - {"autoreset_mode", "env_count"})
        self.pool = Pool(
            game, 1, server=server, art=art, autoreset_mode="disabled", **options
        )
        self._untouched, self._is_over = True, False

    def reset(self, level_seed: int | None = None) -> dm_env.TimeStep:
        """Starts an episode: in a level, or None: the next of the choice of levels."""
        if self._untouched and level_seed is None:
            batch = self.pool.observe()
        else:
            batch = self.pool.reset([Reset(0, level_seed)])
        self._untouched = self._is_over = False
        return dm_env.restart(_frame_of(batch))

    def step(self, action: int) -> dm_env.TimeStep:
        """Steps; the first step, and one after the last of an episode, start an episode instead."""
        if self._untouched or self._is_over:
            return self.reset()
        batch = self.pool.step([action])
        observation, reward = _frame_of(batch), float(batch.rewards[0])
        self._is_over = bool(batch.ended[0])
        if batch.truncated[0]:
            return dm_env.truncation(reward, observation)
        if self._is_over:
            return dm_env.termination(reward, observation)
        return dm_env.transition(reward, observation)

    def observation_spec(self) -> specs.BoundedArray:
        """Returns uint8 [64, 64, 3], or the shape of the options."""
        shape = self.pool.observation_shape
        return specs.BoundedArray(shape, np.uint8, 0, 255, name="observation")

    def action_spec(self) -> specs.DiscreteArray:
        """Returns the integers in [0, 15)."""
        return specs.DiscreteArray(ACTION_COUNT, np.int32, name="action")

    def close(self) -> None:
        """Closes the pool. Closing again does nothing."""
        self.pool.close()


def _frame_of(batch: Batch) -> np.ndarray:
    frame: np.ndarray = batch.observations[0]
    return frame
