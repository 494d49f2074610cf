"""Recordings are files that depend on nothing but their arguments."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from small_recordings import OPTIONS, recorded

from procgen_client import Pool, errors
from procgen_client.dataset import load, parts_of, record


def test_parts_are_those_of_one_pool(tmp_path: Path) -> None:
    files = recorded(tmp_path, env_count=70, step_count=70)
    parts = [load(path) for path in files]
    assert [part.actions.shape for part in parts] == [(64, 64), (6, 64)]
    actions = np.concatenate([part.actions for part in parts])
    rewards = np.concatenate([part.rewards for part in parts])
    with Pool("bigfish", 70, rand_seed=0, **OPTIONS) as pool:
        for taken, expected in zip(actions.T.astype(int), rewards.T):
            np.testing.assert_array_equal(pool.step(taken, observe=False).rewards, expected)


@pytest.mark.parametrize(
    ("step_count", "env_count", "expected"),
    [
        (1, None, [(1, 64)]),
        (1000, None, [(16, 64)]),
        (4096, None, [(64, 64)]),
        (300_000, None, [(64, 2368), (64, 2368)]),
        (1_000_000, None, [(64, 3968)] * 4),
        (1000, 3, [(3, 384)]),
    ],
)
def test_steps_are_divided(
    tmp_path: Path, step_count: int, env_count: int | None, expected: list[tuple[int, int]]
) -> None:
    parts = parts_of(tmp_path, "bigfish", step_count=step_count, env_count=env_count)
    assert [(part.header.env_count, part.header.step_count) for part in parts] == expected
    assert sum(part.step_count for part in parts) >= step_count
    assert {part.header.total_env_count for part in parts} == {sum(n for n, _ in expected)}


def test_done_parts_are_kept(tmp_path: Path) -> None:
    files = recorded(tmp_path, step_count=10_000)
    before = [path.read_bytes() for path in files]
    files[0].unlink()
    assert [part.is_done for part in parts_of(tmp_path, "bigfish", step_count=10_000,
                                              options=OPTIONS)] == [False]  # fmt: skip
    recorded(tmp_path, step_count=10_000)
    assert [path.read_bytes() for path in files] == before


def test_each_step_is_reported_once(tmp_path: Path) -> None:
    for policy in ("random", "procgen_client.tools.evaluation:random_policy"):
        (part,) = parts_of(tmp_path, "maze", step_count=2000, policy=policy)
        counts: list[int] = []
        record(part, counts.append)
        assert sum(counts) == part.step_count
        part.path.unlink()


def test_other_arguments_are_refused(tmp_path: Path) -> None:
    recorded(tmp_path)
    for changes, message in (
        ({"seed": 4}, "with options .*'rand_seed': 0}, not with .*'rand_seed': 4}"),
        ({"policy": "sticky"}, "with policy 'random', not with 'sticky': repeat the command"),
        ({"step_count": 9000}, "with step_count 64, not with 192"),
        ({"step_count": 300_000}, "is of another recording than 2 parts of bigfish"),
    ):
        with pytest.raises(errors.InvalidArgumentError, match=message):
            recorded(tmp_path, **changes)
    recorded(tmp_path, "maze")  # Another game may be added.


def test_wrong_arguments_are_errors(tmp_path: Path) -> None:
    for changes, message in (
        ({"step_count": 0}, r"steps is 0; it is in \[1,"),
        ({"env_count": 0}, r"environments is 0; it is in \[1,"),
        ({"digest_interval": -1}, r"digest_interval is -1; it is in \[1,"),
        ({"options": {"num_levels": -1}}, "num_levels is -1"),
        ({"options": {"screen_size": 32}}, "has no option 'screen_size'"),
        ({"options": {"distribution_mode": "memory"}}, "memory"),
        ({"policy": "x"}, "it is MODULE:FUNCTION"),
    ):
        with pytest.raises(errors.InvalidArgumentError, match=message):
            parts_of(tmp_path, "bigfish", **{"step_count": 100, **changes})
    with pytest.raises(errors.NotFoundError, match="pong"):
        parts_of(tmp_path, ["bigfish", "pong"], step_count=100)
    assert not list(tmp_path.iterdir())


def test_a_recording_makes_its_folder(tmp_path: Path) -> None:
    (part,) = parts_of(tmp_path / "new" / "data", "coinrun", step_count=64, env_count=2)
    record(part)
    assert part.is_done
