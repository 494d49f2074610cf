"""The choice of levels: requested one by one, by a sampler, and by the curriculum example."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from conftest import MakePool

from procgen_client import (
    LevelSampler,
    Pool,
    Reset,
    ServerProcess,
    errors,
)

_ROOT = Path(__file__).resolve().parents[3]
_EXAMPLE = _ROOT / "clients/python/examples/prioritised_level_replay.py"
_END = -1


def end_episodes(pool: Pool) -> list[int]:
    """Ends all episodes; returns the seeds of the new levels."""
    return pool.step([_END] * pool.env_count).level_seeds.tolist()


def test_sampler_chooses_the_first_level_too(make_pool: MakePool) -> None:
    pool = make_pool("maze", 4, level_sampler=LevelSampler([70, -71]))
    levels = [pool.observe().level_seeds.tolist()] + [end_episodes(pool) for _ in range(9)]
    assert {level for row in levels for level in row} == {70, -71}


def test_replaced_sampler_takes_effect_at_the_next_episode(make_pool: MakePool) -> None:
    pool = make_pool("maze", 4)
    before = pool.observe().level_seeds.tolist()
    pool.set_level_sampler(LevelSampler(np.array([70, 80]), [0.0, 2.5]))
    assert pool.observe().level_seeds.tolist() == before
    assert end_episodes(pool) == [80] * 4
    assert pool.options["level_sampler"].weights == [0.0, 2.5]


def test_requested_levels_override_the_sampler(make_pool: MakePool) -> None:
    pool = make_pool("maze", 3, level_sampler=LevelSampler([70]))
    batch = pool.step([_END] * 3, next_levels={1: -8}, resets=[Reset(2, level_seed=9)])
    assert batch.level_seeds.tolist() == [70, -8, 9]


def test_equal_samplers_choose_equal_levels_by_weight(make_pool: MakePool) -> None:
    def levels(rand_seed: int) -> list[list[int]]:
        sampler = LevelSampler(range(100), [*[1] * 50, *[9] * 50], rand_seed=rand_seed)
        pool = make_pool("maze", 4, level_sampler=sampler)
        return [end_episodes(pool) for _ in range(50)]

    drawn = levels(4)
    assert drawn == levels(4) != levels(5)
    assert 150 < sum(level >= 50 for row in drawn for level in row) < 200, "0.9 of 200"


@pytest.mark.parametrize(
    ("sampler", "message"),
    [
        (LevelSampler([]), r"level_.* has 0 entries, .* 1 to 1000000"),
        (LevelSampler([1.5]), r"level_seeds has shape \[1\] and type float64"),
        (LevelSampler([2**31]), "level_seeds contains 2147483648"),
        (LevelSampler([1, 2], [[1, 2]]), r"weights has shape \[1, 2\]"),
        (LevelSampler([1, 2], [1]), r"weights has shape \[1\]"),
        (LevelSampler([1, 2], [1, float("nan")]), r"weights\[1\] is nan"),
        (LevelSampler([1, 2], [1, -1]), r"weights\[1\] is -1"),
        (LevelSampler([1], rand_seed=0.5), "rand_seed is 0.5"),
    ],
)
def test_invalid_samplers_are_rejected(
    make_pool: MakePool, sampler: LevelSampler, message: str
) -> None:
    with pytest.raises(errors.InvalidArgumentError, match=message):
        make_pool("maze", 2, level_sampler=sampler)
    pool = make_pool("maze", 2)
    with pytest.raises(errors.InvalidArgumentError, match=message):
        pool.set_level_sampler(sampler)
    assert pool.step([4, 4]).episode_lengths.tolist() == [1, 1], "the pool continues"


def test_example_prefers_some_levels(server: ServerProcess) -> None:
    command = [sys.executable, str(_EXAMPLE), f"--server={server.address}"]
    command += ["--levels=20", "--environments=16"]
    run = subprocess.run(
        [*command, "--steps=400", "--steps-per-sampler=100"],
        env=os.environ | {"PYTHONPATH": str(_ROOT / "clients/python")},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    lines = run.stdout.splitlines()
    assert lines[3].startswith("step 400 of 400: ")
    counts = [int(line.split(": ")[1].split()[0]) for line in lines[4:]]
    assert len(counts) == 5
    assert counts[0] > counts[-1] >= 1
