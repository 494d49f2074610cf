"""The choice of levels: requested one by one, by a sampler, and by the curriculum example."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from procgen_client import (
    Client,
    LevelSampler,
    Pool,
    ProcgenVectorEnv,
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


def test_sampler_chooses_the_first_level_too(client: Client) -> None:
    with client.create_pool("maze", 4, level_sampler=LevelSampler([70, -71])) as pool:
        levels = [pool.observe().level_seeds.tolist()] + [end_episodes(pool) for _ in range(9)]
        assert {level for row in levels for level in row} == {70, -71}


def test_replaced_sampler_takes_effect_at_the_next_episode(client: Client) -> None:
    with client.create_pool("maze", 4) as pool:
        before = pool.observe().level_seeds.tolist()
        pool.set_level_sampler(LevelSampler(np.array([70, 80]), [0.0, 2.5]))
        assert pool.observe().level_seeds.tolist() == before
        assert end_episodes(pool) == [80] * 4


def test_requested_levels_override_the_sampler(client: Client) -> None:
    with client.create_pool("maze", 3, level_sampler=LevelSampler([70])) as pool:
        batch = pool.step([_END] * 3, next_levels={1: -8}, resets=[Reset(2, level_seed=9)])
        assert batch.level_seeds.tolist() == [70, -8, 9]


def test_equal_samplers_choose_equal_levels(client: Client) -> None:
    sampler = LevelSampler(range(100), rand_seed=4)
    levels = []
    for _ in range(2):
        with client.create_pool("maze", 4, level_sampler=sampler) as pool:
            levels.append([end_episodes(pool) for _ in range(5)])
    assert levels[0] == levels[1]


def test_vector_environment_accepts_a_sampler(server: ServerProcess) -> None:
    with ProcgenVectorEnv(
        "maze", 3, server=server.address, level_sampler=LevelSampler([70])
    ) as environment:
        environment.reset()
        assert environment.pool.observe().level_seeds.tolist() == [70] * 3


@pytest.mark.parametrize(
    ("sampler", "message"),
    [
        (LevelSampler([]), "level_seeds has 0 entries, must have 1 to 1000000"),
        (LevelSampler([1.5]), "level_seeds has shape [1] and type float64"),
        (LevelSampler([2**31]), "LevelSampler has a wrong value"),
        (LevelSampler([1, 2], [[1, 2]]), "weights has shape [1, 2]"),
        (LevelSampler([1, 2], [1]), "weights has 1 entries, must have 2"),
        (LevelSampler([1, 2], [1, float("nan")]), "weights[1] is nan"),
    ],
)
def test_invalid_samplers_are_rejected(client: Client, sampler: LevelSampler, message: str) -> None:
    with pytest.raises(errors.InvalidArgumentError) as raised:
        client.create_pool("maze", 2, level_sampler=sampler)
    assert message in str(raised.value)
    with client.create_pool("maze", 2) as pool:
        with pytest.raises(errors.InvalidArgumentError) as raised:
            pool.set_level_sampler(sampler)
        assert message in str(raised.value)
        assert pool.observe().first.all(), "the pool continues"


def test_sampler_cannot_be_set_while_requests_are_in_flight(client: Client) -> None:
    with client.create_pool("maze", 2) as pool:
        pool.send_observe()
        with pytest.raises(errors.FailedPreconditionError):
            pool.set_level_sampler(LevelSampler([1]))
        pool.receive()


def test_example_prefers_some_levels(server: ServerProcess) -> None:
    command = [sys.executable, str(_EXAMPLE), server.address, "--levels=20", "--environments=16"]
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
