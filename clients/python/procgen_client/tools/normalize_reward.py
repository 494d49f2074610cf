"""Normalisation of rewards by the running variance of the discounted return."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from procgen_client.errors import InvalidArgumentError


class NormalizeReward:
    """Divides rewards by the standard deviation of the discounted returns seen so far.

    As VecNormalize of baselines, which the paper's code uses, and Gymnasium's NormalizeReward. Call
    it after each step::

        normalize = NormalizeReward(env.num_envs, gamma=0.999)
        observations, rewards, terminations, truncations, infos = env.step(actions)
        rewards = normalize(rewards, terminations | truncations)

    Threads: one at a time.
    """

    def __init__(
        self, num_envs: int, *, gamma: float = 0.99, clip: float = 10.0, epsilon: float = 1e-8
    ) -> None:
        """Starts with a variance of 1, which has the weight of 1e-4 returns.

        Args:
            num_envs: Number of environments, N.
            gamma: Discount factor, in [0, 1].
            clip: Largest absolute value of a normalised reward.
            epsilon: Added to the variance.

        Raises:
            InvalidArgumentError: gamma is out of range.
        """
        if not 0 <= gamma <= 1:
            raise InvalidArgumentError(f"gamma is {gamma}; it is in [0, 1]")
        self._gamma, self._clip, self._epsilon = gamma, clip, epsilon
        self._returns = np.zeros(num_envs)
        self._mean, self._variance, self._count = 0.0, 1.0, 1e-4

    def __call__(self, rewards: np.ndarray, ended: np.ndarray) -> np.ndarray:
        """Adds a step to the statistics and returns its normalised rewards.

        Args:
            rewards: Floats [N].
            ended: Whether the step ended the episode, bool [N].

        Returns:
            Normalised rewards [N], of the type of `rewards`.

        Raises:
            InvalidArgumentError: An array has another shape. Nothing was added.
        """
        self._check_shape("rewards", rewards)
        self._check_shape("ended", ended)
        self._returns = self._returns * self._gamma + rewards
        self._add(self._returns)
        deviation = rewards.dtype.type(np.sqrt(self._variance + self._epsilon))
        self._returns[ended] = 0
        normalized: np.ndarray = (rewards / deviation).clip(-self._clip, self._clip)
        return normalized

    def state_dict(self) -> dict[str, Any]:
        """Returns a copy of the state, for a checkpoint.

        Returns:
            ``returns``: discounted returns of the running episodes, a list. ``mean``, ``variance``,
            ``count``: of all returns.
        """
        return {
            "returns": self._returns.tolist(),
            "mean": float(self._mean),
            "variance": float(self._variance),
            "count": self._count,
        }

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continues from a state of state_dict, bit for bit; gamma and clip do not change.

        Raises:
            InvalidArgumentError: The state has other keys, or another number of environments.
        """
        if state.keys() != self.state_dict().keys():
            raise InvalidArgumentError(
                f"state has keys {', '.join(sorted(state))}; it has "
                f"{', '.join(sorted(self.state_dict()))}"
            )
        returns = np.array(state["returns"], np.float64)
        self._check_shape("returns", returns)
        self._returns = returns
        self._mean, self._variance, self._count = (
            float(state[name]) for name in ("mean", "variance", "count")
        )

    def _check_shape(self, name: str, array: np.ndarray) -> None:
        if array.shape != self._returns.shape:
            raise InvalidArgumentError(
                f"{name} has shape {list(array.shape)}; it is {list(self._returns.shape)}"
            )

    def _add(self, values: np.ndarray) -> None:
        """Adds values to the running mean and variance."""
        total = self._count + values.size
        delta = values.mean() - self._mean
        squares = self._variance * self._count + values.var() * values.size
        squares += delta**2 * self._count * values.size / total
        self._mean += delta * values.size / total
        self._variance, self._count = squares / total, total
