"""Tests on all levels while a run trains."""

from __future__ import annotations

import argparse
from collections import deque
from typing import Any

import numpy as np

from learners.agent import AgentPolicy
from learners.environments import Environments, environment_options

TEST_COLUMNS = ("step", "return_mean", "length_mean")
EPISODE_WINDOW = 100  # Number of episodes in return_mean and length_mean.


class PeriodicEvaluation:
    """Plays a policy in environments of its own, as the test worker of the paper's code.

    Episodes continue from one test to the next, so that short ones are not preferred.
    """

    def __init__(self, options: argparse.Namespace, policy: AgentPolicy) -> None:
        """Makes as many environments as the run has, on all levels."""
        self._policy = policy
        self._step_count: int = options.num_steps
        its_options = environment_options(options, 0, 1) | {"num_levels": 0, "watch": None}
        its_options.pop("frame_stack", None)  # The policy stacks frames itself.
        self._environments = Environments(options.game, options.num_envs, **its_options)
        self._recent: deque[tuple[float, int]] = deque(maxlen=EPISODE_WINDOW)
        self._first = np.ones(options.num_envs, bool)

    def play(self) -> list[float | str]:
        """Takes num_steps steps of each environment.

        Returns:
            The means of return and length over the last EPISODE_WINDOW episodes; "" before the
            first one.
        """
        pool = self._environments.pool
        observations = pool.observe().observations
        for _ in range(self._step_count):
            batch = pool.step(self._policy(observations, self._first))
            observations, self._first = batch.observations, batch.ended.copy()
            ended = np.flatnonzero(batch.ended)
            returns, lengths = batch.episode_returns[ended], batch.episode_lengths[ended]
            self._recent.extend(zip(returns.tolist(), lengths.tolist(), strict=True))
        return [float(mean) for mean in np.mean(self._recent, 0)] if self._recent else ["", ""]

    def state(self) -> dict[str, Any]:
        """Returns all state, for a checkpoint."""
        return {
            "states": self._environments.pool.save_states(),
            "policy": self._policy.state(),
            "recent": list(self._recent),
            "first": self._first,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Continues from a checkpoint."""
        self._environments.pool.restore_states(state["states"])
        self._policy.restore(state["policy"])
        self._recent.extend(state["recent"])
        self._first = state["first"]

    def close(self) -> None:
        """Closes the environments."""
        self._environments.close()
