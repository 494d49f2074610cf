"""Prioritised experience replay (Schaul et al., 2016) in a memory-mapped file.

A row is a step of all N environments; rows form a ring. A checkpoint only writes the pages that
have changed since the last one.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

OBSERVATION_SHAPE = (64, 64, 3)
# Share of additional rows, which are written between two checkpoints. A killed run therefore
# continues with the rows of its checkpoint.
_SLACK = 0.05


class SumTree:
    """Priorities in a binary tree of sums; sampling takes logarithmic time."""

    def __init__(self, size: int) -> None:
        """Starts with all priorities 0."""
        self._leaf_count = 1 << max(1, (size - 1).bit_length())
        self._sums = np.zeros(2 * self._leaf_count)  # Node i is the sum of 2 i and 2 i + 1.

    @property
    def total(self) -> float:
        """Sum of all priorities."""
        return float(self._sums[1])

    def __getitem__(self, indices: np.ndarray) -> np.ndarray:
        """Returns priorities."""
        return self._sums[indices + self._leaf_count]

    def __setitem__(self, indices: np.ndarray, priorities: np.ndarray | float) -> None:
        """Sets priorities; for repeated indices the last one."""
        nodes = np.asarray(indices) + self._leaf_count
        self._sums[nodes] = priorities
        while nodes[0] > 1:
            nodes = np.unique(nodes >> 1)
            self._sums[nodes] = self._sums[2 * nodes] + self._sums[2 * nodes + 1]

    def find(self, sums: np.ndarray) -> np.ndarray:
        """Returns for each sum the first index whose cumulative priority exceeds it."""
        sums = sums.copy()
        nodes = np.ones(len(sums), np.int64)
        while nodes[0] < self._leaf_count:
            nodes *= 2
            left = self._sums[nodes]
            # Rounding must not lead to a priority of 0 beyond the last one.
            is_right = (sums >= left) & (self._sums[nodes + 1] > 0)
            sums = np.where(is_right, sums - left, sums)
            nodes += is_right
        return nodes - self._leaf_count

    def leaves(self) -> np.ndarray:
        """Returns all priorities."""
        return self._sums[self._leaf_count :].copy()


class Transitions(NamedTuple):
    """A sample of n-step transitions."""

    indices: np.ndarray  # For set_priorities   int64 [B]
    observations: np.ndarray  # uint8   [B, 64, 64, 3]
    actions: np.ndarray  # int64   [B]
    returns: np.ndarray  # Discounted rewards of n steps, up to the episode's end   float32 [B]
    discounts: np.ndarray  # Of the value after n steps; 0: the episode ended   float32 [B]
    next_observations: np.ndarray  # uint8   [B, 64, 64, 3]
    weights: np.ndarray  # Of importance sampling, at most 1   float32 [B]


class Replay:
    """The last steps of N environments.

    Attributes:
        row_count: Total number of added rows.
        slack: Maximum number of rows added between two checkpoints.
    """

    def __init__(
        self,
        path: Path,
        capacity: int,
        env_count: int,
        *,
        slack_min: int,
        n: int,
        gamma: float,
        alpha: float,
    ) -> None:
        """Opens the ring, and creates the file if it does not exist.

        Args:
            path: File of the observations.
            capacity: Number of observations.
            env_count: Number of environments, N.
            slack_min: Lower bound of `slack`.
            n: Steps of a transition.
            gamma: Discount of one step.
            alpha: Exponent of priorities.
        """
        self._capacity = capacity // env_count
        if self._capacity <= n:
            raise ValueError(f"a replay of {capacity} observations is less than {n} steps")
        self.slack = max(slack_min, round(self._capacity * _SLACK))
        self._rows = self._capacity + self.slack
        self._env_count, self._n, self._gamma, self._alpha = env_count, n, gamma, alpha
        shape = (self._rows, env_count)
        path.parent.mkdir(parents=True, exist_ok=True)
        self._observations = np.memmap(
            path, np.uint8, "r+" if path.exists() else "w+", shape=(*shape, *OBSERVATION_SHAPE)
        )
        self._actions = np.zeros(shape, np.uint8)
        self._rewards = np.zeros(shape, np.float32)
        self._ended = np.zeros(shape, bool)
        self._tree = SumTree(self._rows * env_count)
        self._priority_max = 1.0
        self.row_count = 0

    def add(self, rows: slice, observations: np.ndarray, actions: np.ndarray) -> None:
        """Writes observations and actions of some environments to the current row."""
        row = self.row_count % self._rows
        self._observations[row, rows] = observations
        self._actions[row, rows] = actions

    def finish(self) -> None:
        """Ends the current row.

        The row n steps before becomes a transition with the largest priority, and the oldest row is
        dropped. :meth:`set_outcome` adds the rewards of the row that ended.
        """
        newest = self.row_count
        self.row_count += 1
        if newest >= self._n:
            self._tree[self._leaves(newest - self._n)] = self._priority_max
        if newest >= self._capacity:
            self._tree[self._leaves(newest - self._capacity)] = 0.0

    def set_outcome(self, rows: slice, rewards: np.ndarray, ended: np.ndarray) -> None:
        """Writes rewards and ends of the row that was ended last."""
        row = (self.row_count - 1) % self._rows
        self._rewards[row, rows], self._ended[row, rows] = rewards, ended

    def sample(self, size: int, beta: float, random: np.random.Generator) -> Transitions:
        """Draws transitions by priority, one from each of `size` equal parts of their sum."""
        total = self._tree.total
        indices = self._tree.find((np.arange(size) + random.random(size)) * (total / size))
        row, environment = np.divmod(indices, self._env_count)
        returns = np.zeros(size, np.float32)
        discounts = np.ones(size, np.float32)
        for k in range(self._n):
            step = (row + k) % self._rows
            returns += discounts * self._rewards[step, environment]
            discounts *= np.float32(self._gamma) * ~self._ended[step, environment]
        transition_count = min(self.row_count, self._capacity) * self._env_count
        weights = (transition_count * self._tree[indices] / total) ** -beta
        return Transitions(
            indices,
            self._observations[row, environment],
            self._actions[row, environment].astype(np.int64),
            returns,
            discounts,
            self._observations[(row + self._n) % self._rows, environment],
            (weights / weights.max()).astype(np.float32),
        )

    def set_priorities(self, indices: np.ndarray, losses: np.ndarray) -> None:
        """Sets the priorities of a sample from its losses."""
        priorities = (losses.astype(np.float64) + 1e-6) ** self._alpha
        self._tree[indices] = priorities
        self._priority_max = max(self._priority_max, float(priorities.max()))

    def state(self) -> dict[str, Any]:
        """Returns all state but the observations, and writes those to disk."""
        self._observations.flush()
        return {
            "actions": self._actions,
            "rewards": self._rewards,
            "ended": self._ended,
            "priorities": self._tree.leaves(),
            "priority_max": self._priority_max,
            "row_count": self.row_count,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Continues from a checkpoint."""
        self._actions, self._rewards = state["actions"], state["rewards"]
        self._ended = state["ended"]
        self._tree[np.arange(len(state["priorities"]))] = state["priorities"]
        self._priority_max, self.row_count = state["priority_max"], state["row_count"]

    def _leaves(self, row: int) -> np.ndarray:
        first = row % self._rows * self._env_count
        return np.arange(first, first + self._env_count)
