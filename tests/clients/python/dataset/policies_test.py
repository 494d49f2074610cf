"""Policies of recordings."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from procgen_client import Pool, errors
from procgen_client.dataset import Header
from procgen_client.dataset.policies import check_policy, policy_actions

_POLICIES = """
import numpy as np

def bright(game):
    return lambda observations: observations.mean(axis=(1, 2, 3)).astype(int) % 15

def seeded(game, seed):
    random = np.random.default_rng(seed)
    calls = []
    def policy(observations, first):
        calls.append(first)
        assert first.all() == (len(calls) == 1)
        return random.integers(0, 15, len(first))
    return policy

def wrong(game):
    return lambda observations: [99] * len(observations)
"""


def _header(policy: str, first_env: int = 0, step_count: int = 500) -> Header:
    options = {"distribution_mode": "easy", "rand_seed": 3}
    return Header("bigfish", 8, step_count, options, first_env, 100, policy=policy)


def _actions(policy: str, seed: int = 0, **arguments: int) -> np.ndarray:
    return policy_actions(_header(policy, **arguments), seed, lambda _: None)


@pytest.fixture
def _module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "some_policies.py").write_text(_POLICIES)
    monkeypatch.syspath_prepend(tmp_path)
    sys.modules.pop("some_policies", None)


def test_random_actions_depend_on_seed_and_environments() -> None:
    actions = _actions("random")
    assert actions.dtype == np.int8
    assert np.bincount(actions.ravel(), minlength=15).min() > 200
    np.testing.assert_array_equal(actions, _actions("random"))
    assert (actions != _actions("random", seed=1)).mean() > 0.8
    assert (actions != _actions("random", first_env=8)).mean() > 0.8
    assert (actions[0] != actions[1]).mean() > 0.8


@pytest.mark.parametrize(("policy", "probability"), [("sticky", 0.9), ("sticky:0.5", 0.5)])
def test_sticky_actions_are_repeated(policy: str, probability: float) -> None:
    actions = _actions(policy, step_count=5000)
    repeated = (actions[:, 1:] == actions[:, :-1]).mean()
    # A new action equals the last one once in fifteen times.
    assert repeated == pytest.approx(probability + (1 - probability) / 15, abs=0.01)
    assert np.unique(actions).tolist() == list(range(15))


@pytest.mark.usefixtures("_module")
def test_function_chooses_actions_from_frames() -> None:
    counts: list[int] = []
    header = _header("some_policies:bright", step_count=60)
    actions = policy_actions(header, 0, counts.append)
    assert sum(counts) == 8 * 60
    with Pool("bigfish", 8, total_env_count=100, **header.options) as pool:
        for taken in actions.T.astype(int):
            frames = pool.observe().observations
            np.testing.assert_array_equal(taken, frames.mean(axis=(1, 2, 3)).astype(int) % 15)
            pool.step(taken)


@pytest.mark.usefixtures("_module")
def test_function_with_a_seed_gets_another_one_for_each_part() -> None:
    first, second = (_actions("some_policies:seeded", first_env=i, step_count=20) for i in (0, 8))
    assert (first != second).mean() > 0.8


@pytest.mark.usefixtures("_module")
def test_wrong_policies_are_errors() -> None:
    for name in ("sticky:1", "sticky:x", "sticky:-0.1"):
        with pytest.raises(errors.InvalidArgumentError, match=r"the P of sticky:P is in \[0, 1\)"):
            check_policy(name)
    with pytest.raises(errors.InvalidArgumentError, match="it is MODULE:FUNCTION"):
        check_policy("clever")
    with pytest.raises(errors.InvalidArgumentError, match="no attribute 'none'"):
        check_policy("some_policies:none")
    with pytest.raises(errors.InvalidArgumentError, match="99"):
        _actions("some_policies:wrong")
