"""With a policy lag, a rollout is collected with the weights of before the update beside it."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest
from small_runs import STEPS_OF_UPDATE, train

from learners import ppo


def test_rollouts_are_learned_from_one_update_later(tmp_path: Path) -> None:
    plain = train(tmp_path / "plain", total_steps=STEPS_OF_UPDATE)
    lagging = train(tmp_path / "lagging", policy_lag=1)
    first, second = (
        [line.split(",", 1)[1] for line in run["learning"].splitlines()]
        for run in (plain, lagging)
    )
    assert second[1] == ",".join(["nan"] * 6)
    assert second[2] == first[1], "the first rollout"
    assert len(set(second)) == 5

    fixed = train(tmp_path / "fixed", learning_rate=0, total_steps=3 * STEPS_OF_UPDATE)

    def episodes(run: dict[str, str], begin: int, end: int) -> list[str]:
        rows = run["episodes"].splitlines()[1:]
        return [row for row in rows if begin < int(row.split(",")[0]) <= end]

    with_first_weights = 2 * STEPS_OF_UPDATE
    assert episodes(lagging, 0, with_first_weights) == episodes(fixed, 0, with_first_weights) != []
    later = (with_first_weights, 3 * STEPS_OF_UPDATE)
    assert episodes(lagging, *later) != episodes(fixed, *later)


@pytest.mark.parametrize("lstm", [None, True])
def test_stopped_run_equals_an_uninterrupted_one(
    tmp_path: Path, lstm: bool | None  # noqa: FBT001 - a parameter of the test
) -> None:
    common = {"policy_lag": 1, "lstm": lstm, "total_steps": 3 * STEPS_OF_UPDATE}
    whole = train(tmp_path / "whole", threads=1, **common)
    for _ in range(3):
        parts = train(tmp_path / "parts", time_limit=0, resume=True, **common)
    assert parts == whole


def test_thread_learns_while_another_collects(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    threads = []
    learn = ppo.Ppo.learn

    def observed(self: ppo.Ppo) -> list[float]:
        threads.append(threading.current_thread())
        return learn(self)

    monkeypatch.setattr(ppo.Ppo, "learn", observed)
    train(tmp_path, policy_lag=1)
    assert [thread is threading.main_thread() for thread in threads] == [True, False, False]
