"""Rewards are divided by the standard deviation of the discounted returns seen so far."""

from __future__ import annotations

import json

import numpy as np
import pytest

from procgen_client import NormalizeReward, errors

_REWARDS = np.float32([[1, 0], [0, 2], [3, 0]])
_ENDED = np.array([[False, True], [False, False], [True, False]])


def _random_steps(count: int) -> list[tuple[np.ndarray, np.ndarray]]:
    random = np.random.default_rng(0)
    return [(random.normal(size=4) * 9, random.random(4) < 0.2) for _ in range(count)]


def test_rewards_are_divided_by_the_standard_deviation_of_returns() -> None:
    normalize = NormalizeReward(2, gamma=0.5)
    returns = np.array([1, 0, 0.5, 2, 3.25, 1])
    for t in range(3):
        normalized = normalize(_REWARDS[t], _ENDED[t])
        deviation = returns[: 2 * t + 2].std()
        assert normalized == pytest.approx(_REWARDS[t] / deviation, rel=1e-3)
        assert normalized.dtype == np.float32


def test_variance_is_that_of_all_returns() -> None:
    # As the parallel algorithm of Chan et al.: equal to the variance of the concatenation.
    normalize = NormalizeReward(4, gamma=0.9)
    running, returns = np.zeros(4), []
    for rewards, ended in _random_steps(200):
        normalize(rewards, ended)
        running = running * 0.9 + rewards
        returns.append(running)
        running = np.where(ended, 0, running)
    state = normalize.state_dict()
    assert state["variance"] == pytest.approx(np.var(returns), rel=1e-5)
    assert state["mean"] == pytest.approx(np.mean(returns), rel=1e-5)
    np.testing.assert_array_equal(state["returns"], running)


def test_normalized_rewards_are_clipped() -> None:
    normalize = NormalizeReward(2, clip=1.5)
    never = np.zeros(2, bool)
    for _ in range(100):
        normalize(np.array([1.0, -1.0]), never)
    assert normalize(np.array([100.0, -100.0]), never).tolist() == [1.5, -1.5]


def test_restored_normalizer_continues_bit_for_bit() -> None:
    whole, first = NormalizeReward(4), NormalizeReward(4)
    steps = _random_steps(40)
    expected = [whole(*step) for step in steps]
    for step in steps[:20]:
        first(*step)
    state = json.loads(json.dumps(first.state_dict()))  # It has only Python's own types.
    first(*steps[20])  # Does not change the state that was returned.
    second = NormalizeReward(4)
    second.load_state_dict(state)
    np.testing.assert_array_equal([second(*step) for step in steps[20:]], expected[20:])


def test_wrong_arguments_are_rejected() -> None:
    normalize = NormalizeReward(2)
    with pytest.raises(errors.InvalidArgumentError, match=r"rewards has shape \[3\]; it is \[2\]"):
        normalize(np.zeros(3), np.zeros(3, bool))
    with pytest.raises(errors.InvalidArgumentError, match=r"ended has shape \[1\]; it is \[2\]"):
        normalize(np.zeros(2), np.zeros(1, bool))
    with pytest.raises(errors.InvalidArgumentError, match=r"returns has shape \[3\]; it is \[2\]"):
        normalize.load_state_dict(NormalizeReward(3).state_dict())
    with pytest.raises(errors.InvalidArgumentError, match="state has keys count, mean, returns; "):
        state = normalize.state_dict()
        del state["variance"]
        normalize.load_state_dict(state)
    with pytest.raises(errors.InvalidArgumentError, match="gamma is 1.5"):
        NormalizeReward(2, gamma=1.5)
