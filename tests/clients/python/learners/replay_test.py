"""The replay samples n-step transitions by priority and can be restored."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("torch")

from learners.replay import Replay, SumTree


def test_sum_tree_equals_a_cumulative_sum() -> None:
    random = np.random.default_rng(0)
    priorities = random.integers(0, 3, 37).astype(float)
    tree = SumTree(37)
    tree[np.arange(37)] = priorities
    tree[np.array([3, 3, 9])] = np.array([1.0, 5.0, 0.0])
    priorities[[3, 9]] = 5, 0
    assert tree.total == priorities.sum()
    wanted = np.arange(0, priorities.sum(), 0.5)
    assert (tree.find(wanted) == np.searchsorted(priorities.cumsum(), wanted, "right")).all()


def _make(path: Path, **options: Any) -> Replay:  # noqa: ANN401
    defaults = {"slack_min": 4, "n": 2, "gamma": 0.5, "alpha": 1.0}
    return Replay(path / "replay.bin", 20, 2, **(defaults | options))


def _play(replay: Replay, count: int) -> None:
    """Adds rows: pixels are the row's number, rewards are 1, every tenth row ends the episodes."""
    for _ in range(count):
        t = replay.row_count
        for rows in (slice(0, 1), slice(1, 2)):
            pixels = np.full((1, 64, 64, 3), t % 256, np.uint8)
            replay.add(rows, pixels, np.array([t % 15]))
        replay.finish()
        for rows in (slice(0, 1), slice(1, 2)):
            replay.set_outcome(rows, np.ones(1), np.full(1, t % 10 == 9))


def test_transitions_span_n_steps_and_end_with_episodes(tmp_path: Path) -> None:
    replay = _make(tmp_path)
    _play(replay, 25)
    sample = replay.sample(200, 1.0, np.random.default_rng(0))
    t = sample.observations[:, 0, 0, 0].astype(int)
    # Of the last 10 rows, the last 2 do not have an observation n steps later yet.
    assert set(t) == set(range(15, 23))
    assert (sample.next_observations[:, 0, 0, 0] == t + 2).all()
    assert (sample.actions == t % 15).all()
    ends_at_once, ends_next = t == 19, t == 18
    assert (sample.returns == np.where(ends_at_once, 1.0, 1.5)).all()
    assert (sample.discounts == np.where(ends_at_once | ends_next, 0.0, 0.25)).all()
    assert (sample.weights == 1).all()


def test_larger_losses_are_sampled_more_often_with_smaller_weight(tmp_path: Path) -> None:
    replay = _make(tmp_path)
    _play(replay, 10)
    first = replay.sample(100, 1.0, np.random.default_rng(0))
    losses = np.where(first.indices == first.indices[0], 4.0, 1.0)
    replay.set_priorities(first.indices, losses)
    sample = replay.sample(1000, 1.0, np.random.default_rng(0))
    preferred = sample.indices == first.indices[0]
    rest = len(set(sample.indices)) - 1
    assert preferred.mean() == pytest.approx(4 / (4 + rest), abs=0.01)
    assert sample.weights[preferred] == pytest.approx(0.25)
    assert sample.weights[~preferred] == pytest.approx(1)


def test_restored_replay_has_the_rows_of_its_state(tmp_path: Path) -> None:
    replay = _make(tmp_path)
    _play(replay, 33)
    state = {
        name: value.copy() if isinstance(value, np.ndarray) else value
        for name, value in replay.state().items()
    }
    before = replay.sample(200, 0.5, np.random.default_rng(0))
    _play(replay, replay.slack)  # The run is killed after these rows.
    again = _make(tmp_path)
    again.restore(state)
    for one, other in zip(before, again.sample(200, 0.5, np.random.default_rng(0)), strict=True):
        assert (one == other).all()


def test_replay_smaller_than_a_transition_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="a replay of 20 observations is less than 10 steps"):
        _make(tmp_path, n=10)
