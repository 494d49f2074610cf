"""Pickle and copy.deepcopy copy pools and environments as they are, with their states."""

from __future__ import annotations

import copy
import hashlib
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import assert_same

from procgen_client import (
    Client,
    LevelSampler,
    Pool,
    ProcgenEnv,
    ProcgenGym3Env,
    ProcgenGymEnv,
    ProcgenVectorEnv,
    ServerProcess,
    errors,
)

_N = 3
_OPTIONS: dict[str, Any] = {"distribution_mode": "easy", "num_levels": 50, "start_level": 7}
_COPIES = pytest.mark.parametrize(
    "copied", [copy.deepcopy, lambda each: pickle.loads(pickle.dumps(each))], ids=["copy", "pickle"]
)
_Copied = Callable[[Any], Any]
_DIGEST = """
import hashlib, pickle, sys
pool = pickle.loads(sys.stdin.buffer.read())
digest = hashlib.sha256()
for t in range(40):
    batch = pool.step([(t * 3 + i) % 16 - 1 for i in range(pool.env_count)])
    digest.update(batch.observations.tobytes() + batch.level_seeds.tobytes())
print(digest.hexdigest())
"""


def _actions(t: int) -> list[int]:
    return [(t * 3 + i) % 16 - 1 for i in range(_N)]


@pytest.fixture(params=["process", "server"])
def address(request: pytest.FixtureRequest) -> str | None:
    """Each place of pools, as an argument that can be copied."""
    if request.param == "process":
        return None
    process: ServerProcess = request.getfixturevalue("server")
    return process.address


@_COPIES
@pytest.mark.parametrize("stepped", [0, 30])
@pytest.mark.parametrize("sampler", [None, LevelSampler([3, 4, 5], [1, 2, 3])])
def test_copied_pool_continues_as_the_original(
    address: str | None, copied: _Copied, stepped: int, sampler: LevelSampler | None
) -> None:
    games = ["maze", "bigfish", "coinrun"]
    with Pool(games, _N, server=address, level_sampler=sampler, **_OPTIONS) as pool:
        for t in range(stepped):
            pool.step(_actions(t))
        states = pool.save_states()
        with copied(pool) as twin:
            assert type(twin) is Pool
            for name in ("games", "env_count", "autoreset_mode", "options", "observation_shape"):
                assert getattr(twin, name) == getattr(pool, name), name
            assert (twin.client is None) == (address is None)
            assert_same(twin.observe(), pool.observe())
            for t in range(60):
                batch = twin.step(_actions(t))
                assert_same(batch, pool.step(_actions(t)))
            twin.step([-1] * _N)
            pool.restore_states(states)
            assert twin.save_states() != pool.save_states(), "they are apart"


def test_pool_with_the_connection_of_this_process_is_not_copied(
    client: Client, server: ServerProcess
) -> None:
    for given in (client, server):
        with Pool("maze", _N, server=given) as pool:
            with pytest.raises(errors.FailedPreconditionError, match="give server=ADDRESS"):
                pickle.dumps(pool)


def test_pools_that_are_busy_or_closed_are_not_copied() -> None:
    with Pool("maze", _N) as pool:
        pool.send_observe()
        with pytest.raises(errors.FailedPreconditionError, match="unanswered"):
            copy.deepcopy(pool)
        pool.receive()
    with pytest.raises(errors.FailedPreconditionError, match="closed"):
        copy.deepcopy(pool)


def test_pickle_continues_in_another_process() -> None:
    with Pool("ninja", _N, **_OPTIONS) as pool:
        for t in range(20):
            pool.step(_actions(t))
        made = pickle.dumps(pool)
        run = subprocess.run(
            [sys.executable, "-c", _DIGEST], input=made, capture_output=True, check=True
        )
        digest = hashlib.sha256()
        for t in range(40):
            batch = pool.step(_actions(t))
            digest.update(batch.observations.tobytes() + batch.level_seeds.tobytes())
    assert run.stdout.decode().strip() == digest.hexdigest()


@pytest.mark.parametrize("mode", ["same_step", "next_step", "disabled"])
def test_modes_and_formats_are_copied(mode: str) -> None:
    options = {"autoreset_mode": mode, "layout": "chw", "screen_size": 48, "grayscale_obs": True}
    with Pool("maze", _N, **options) as pool:
        pool.step([-1, 4, 4])
        with copy.deepcopy(pool) as twin:
            assert_same(twin.observe(), pool.observe())
            if mode == "disabled":
                for each in (pool, twin):
                    with pytest.raises(errors.FailedPreconditionError):
                        each.step([4] * _N)
                    each.reset([0])
            assert_same(twin.step([4] * _N), pool.step([4] * _N))


def _play_vector(env: ProcgenVectorEnv, t: int) -> list[np.ndarray]:
    return list(env.step(np.maximum(_actions(t), 0))[:4])


def _play_single(env: ProcgenGymEnv, t: int) -> list[np.ndarray]:
    observation, reward, terminated, truncated, _ = env.step(t % 15)
    if terminated or truncated:
        env.reset()
    return [observation, np.array([reward, terminated, truncated])]


def _play_gym3(env: ProcgenGym3Env, t: int) -> list[np.ndarray]:
    env.act(np.maximum(_actions(t), 0))
    reward, observation, first = env.observe()
    return [reward, observation["rgb"], first]


def _play_baselines(env: ProcgenEnv, t: int) -> list[np.ndarray]:
    observations, rewards, dones, _ = env.step(np.maximum(_actions(t), 0))
    return [observations["rgb"], rewards, dones]


@_COPIES
@pytest.mark.parametrize(
    ("make", "play"),
    [
        (lambda: ProcgenVectorEnv("bigfish", _N, **_OPTIONS), _play_vector),
        (lambda: ProcgenGymEnv("bigfish", **_OPTIONS), _play_single),
        (lambda: ProcgenGym3Env(_N, "bigfish", **_OPTIONS), _play_gym3),
        (lambda: ProcgenEnv(_N, "bigfish", **_OPTIONS), _play_baselines),
    ],
    ids=["ProcgenVectorEnv", "ProcgenGymEnv", "ProcgenGym3Env", "ProcgenEnv"],
)
def test_copied_environment_continues_as_the_original(
    copied: _Copied, make: Callable[[], Any], play: Callable[[Any, int], list[np.ndarray]]
) -> None:
    env = make()
    if hasattr(env, "reset"):
        env.reset()
    for t in range(25):
        play(env, t)
    twin = copied(env)
    for t in range(100):
        for one, other in zip(play(env, t), play(twin, t), strict=True):
            np.testing.assert_array_equal(one, other)
    env.close()
    play(twin, 100)
    twin.close()


def test_environment_is_copied_with_what_its_next_step_sends(tmp_path: Path) -> None:
    with ProcgenVectorEnv("maze", _N, autoreset_mode="SameStep", **_OPTIONS) as env:
        env.reset()
        env.set_next_levels({1: 4321})
        path = tmp_path / "env.pickle"
        path.write_bytes(pickle.dumps(env))
        with pickle.loads(path.read_bytes()) as twin:
            for each in (env, twin):
                assert each.step([-1] * _N)[4]["level_seed"][1] == 4321
