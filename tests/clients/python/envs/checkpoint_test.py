"""`save` and `load` of environments: a file from which another process continues bit for bit."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest

from procgen_client import (
    AutoresetMode,
    LevelSampler,
    ProcgenEnv,
    ProcgenGym3Env,
    ProcgenGymEnv,
    ProcgenVectorEnv,
    ServerProcess,
    errors,
)

_N = 4
_OPTIONS = {"distribution_mode": "easy", "rand_seed": 1}

MakeEnv = Callable[..., ProcgenVectorEnv]


@pytest.fixture
def make_env() -> Iterator[MakeEnv]:
    """Makes environments that are closed after the test."""
    made: list[ProcgenVectorEnv] = []

    def make(
        games: Sequence[str] = ("bigfish", "coinrun"), num_envs: int = _N, **options: object
    ) -> ProcgenVectorEnv:
        made.append(ProcgenVectorEnv(games, num_envs, **(_OPTIONS | options)))
        return made[-1]

    yield make
    for env in made:
        env.close()


def _actions(t: int) -> np.ndarray:
    """Ends an episode every third step."""
    return np.where(np.arange(_N) * 3 == t % 12, -1, (t + np.arange(_N)) % 9)


def _flat(values: object) -> list[np.ndarray]:
    if isinstance(values, dict):
        values = [entry for item in sorted(values.items()) for entry in item]
    if isinstance(values, tuple | list):
        return [array for value in values for array in _flat(value)]
    if isinstance(values, np.ndarray) and values.dtype == object:
        return _flat(values.tolist())
    return [np.asarray(values)]


def _assert_equal(one: object, other: object) -> None:
    for left, right in zip(_flat(one), _flat(other), strict=True):
        np.testing.assert_array_equal(left, right)


def _step(env: ProcgenVectorEnv, t: int) -> tuple:
    actions = _actions(t)
    ended = env.episodes_over
    if env.metadata["autoreset_mode"] is AutoresetMode.DISABLED and ended.any():
        return env.reset(options={"reset_mask": ended})
    return env.step(actions)


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize("saved_at", [0, 3, 4, 17])
def test_loaded_environment_continues_bit_for_bit(
    make_env: MakeEnv, tmp_path: Path, mode: AutoresetMode, saved_at: int
) -> None:
    path = tmp_path / "checkpoint.npz"
    env = make_env(autoreset_mode=mode)
    env.reset()
    last = [_step(env, t) for t in range(saved_at)]
    env.set_next_levels({1: 77})
    env.save(path)
    assert [file.name for file in tmp_path.iterdir()] == [path.name]
    expected = [_step(env, t) for t in range(saved_at, saved_at + 30)]
    assert any((step[2] | step[3]).any() for step in expected if len(step) == 5)
    assert any(77 in step[-1]["level_seed"] for step in expected)

    other = make_env(autoreset_mode=mode, rand_seed=9)
    other.reset(seed=5)
    other.step(_actions(0))
    observations, infos = other.load(path)
    if last:
        np.testing.assert_array_equal(observations, last[-1][0])
        shown = last[-1][-1]["_level_seed"]  # A reset may have been of some environments.
        levels = last[-1][-1]["level_seed"]
        np.testing.assert_array_equal(infos["level_seed"][shown], levels[shown])
    for t, step in enumerate(expected, saved_at):
        _assert_equal(_step(other, t), step)


def test_environment_that_was_not_reset_is_saved(make_env: MakeEnv, tmp_path: Path) -> None:
    env, other = make_env(), make_env(rand_seed=9)
    env.save(tmp_path / "new")
    other.load(tmp_path / "new")
    _assert_equal(other.reset(), env.reset())
    _assert_equal(other.step(_actions(0)), env.step(_actions(0)))


def test_draws_of_a_level_sampler_continue(make_env: MakeEnv, tmp_path: Path) -> None:
    env, other = (make_env(level_sampler=LevelSampler([5, 6, 7, 8, 9])) for _ in range(2))
    env.reset()
    env.save(tmp_path / "sampler")
    other.reset()
    for t in range(20):
        other.step(_actions(t))  # Draws other levels.
    other.load(tmp_path / "sampler")
    for t in range(40):
        step = env.step(_actions(t))
        _assert_equal(other.step(_actions(t)), step)
        assert set(step[-1]["level_seed"].tolist()) <= {5, 6, 7, 8, 9}


_CONTINUES = """
import sys
import numpy as np
from procgen_client import ProcgenVectorEnv
with ProcgenVectorEnv("maze", 4) as env:
    env.load(sys.argv[2])
    np.save(sys.argv[3], [env.step([i, 1, 2, 3])[0] for i in range(9)])
"""


def test_another_process_and_server_continue(make_env: MakeEnv, tmp_path: Path) -> None:
    env = make_env("maze")
    env.reset()
    env.step(_actions(1))
    env.save(str(tmp_path / "maze"))
    with ServerProcess() as other:
        subprocess.run(
            [
                *(sys.executable, "-c", _CONTINUES, other.address),
                *(tmp_path / "maze", tmp_path / "steps.npy"),
            ],
            check=True,
        )
    steps = [env.step([i, 1, 2, 3])[0] for i in range(9)]
    np.testing.assert_array_equal(np.load(tmp_path / "steps.npy"), steps)


def test_single_environment_continues_bit_for_bit(tmp_path: Path) -> None:
    env, other = (ProcgenGymEnv("maze", **_OPTIONS) for _ in range(2))
    env.reset()
    env.step(3)
    env.save(tmp_path / "running")
    expected = [env.step(action) for action in range(9)]
    env.step(-1)
    env.save(tmp_path / "over")
    other.load(tmp_path / "running")
    _assert_equal([other.step(action) for action in range(9)], expected)
    other.load(tmp_path / "over")
    with pytest.raises(errors.FailedPreconditionError, match="the episode is over"):
        other.step(1)
    _assert_equal(other.reset(), env.reset())
    for each in (env, other):
        each.close()


def test_upstream_apis_continue_bit_for_bit(tmp_path: Path) -> None:
    env, other = (ProcgenGym3Env(_N, "bigfish", rand_seed=s) for s in (1, 2))
    env.act(_actions(1))
    env.act(_actions(0))
    env.save(tmp_path / "gym3")  # The step is sent and not observed.
    other.load(tmp_path / "gym3")
    for t in range(30):
        _assert_equal(other.observe(), env.observe())
        _assert_equal(other.get_info(), env.get_info())
        for each in (env, other):
            each.act(_actions(t))
    venv, twin = (ProcgenEnv(_N, "bigfish", rand_seed=s) for s in (1, 2))
    venv.step(_actions(1))
    venv.save(tmp_path / "vec")
    twin.load(tmp_path / "vec")
    _assert_equal(twin.step(_actions(2)), venv.step(_actions(2)))
    for each in (env, other, venv, twin):
        each.close()


def test_checkpoints_of_other_pools_are_rejected(make_env: MakeEnv, tmp_path: Path) -> None:
    path = tmp_path / "maze"
    make_env("maze").save(path)
    for options, message in (
        ({"games": "coinrun"}, r"has games \['maze'\]; this environment has \['coinrun'\]"),
        ({"num_envs": 3}, "has env_count 4; this environment has 3"),
        ({"autoreset_mode": "SameStep"}, "autoreset_mode next_step; .* has same_step"),
    ):
        env = make_env(**({"games": "maze"} | options))
        before = env.reset()[0]
        with pytest.raises(errors.InvalidArgumentError, match=message):
            env.load(path)
        np.testing.assert_array_equal(env.pool.observe().observations, before)


def test_damaged_checkpoints_are_rejected(make_env: MakeEnv, tmp_path: Path) -> None:
    env = make_env("maze")
    env.reset()
    path = tmp_path / "checkpoint"
    env.save(path)
    states, data = env.save_states(), path.read_bytes()
    random = np.random.default_rng(0)
    for length in [0, 1, 100, len(data) - 1, *random.integers(0, len(data), 30)]:
        path.write_bytes(data[:length])
        with pytest.raises(errors.DataLossError, match="checkpoint is .*damaged or truncated"):
            env.load(path)
    for position in [*range(60), *random.integers(0, len(data), 100)]:
        damaged = bytearray(data)
        damaged[position] ^= 1 << random.integers(8)
        path.write_bytes(damaged)
        try:
            env.load(path)
        except errors.DataLossError:
            pass
        assert env.save_states() == states
    with path.open("wb") as file:
        np.save(file, np.zeros(3))
    with pytest.raises(errors.DataLossError, match="is not a checkpoint"):
        env.load(path)
    with pytest.raises(FileNotFoundError):
        env.load(tmp_path / "nothing")


def test_checkpoint_of_another_version_is_rejected(make_env: MakeEnv, tmp_path: Path) -> None:
    env = make_env("maze")
    env.save(tmp_path / "old")
    with np.load(tmp_path / "old") as archive:
        arrays = dict(archive)
    header = arrays["header"].tobytes().replace(b'"version": 1', b'"version": 7')
    arrays["header"] = np.frombuffer(header, np.uint8)
    np.savez(tmp_path / "new.npz", **arrays)
    with pytest.raises(errors.DataLossError, match="has version 7 of the format; .* reads 1"):
        env.load(tmp_path / "new.npz")


def test_failed_save_keeps_the_last_checkpoint(make_env: MakeEnv, tmp_path: Path) -> None:
    env = make_env("maze")
    env.save(tmp_path / "checkpoint")
    before = (tmp_path / "checkpoint").read_bytes()
    env.step_async(_actions(1))
    with pytest.raises(errors.FailedPreconditionError, match="unanswered"):
        env.save(tmp_path / "checkpoint")
    env.step_wait()
    with pytest.raises(OSError):
        env.save(tmp_path / "no such folder" / "checkpoint")
    program = f"""
import resource, signal
from procgen_client import ProcgenVectorEnv, _checkpoint
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
with ProcgenVectorEnv("maze", 4) as env:
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
    try:
        env.save({str(tmp_path / "checkpoint")!r})
    except OSError as error:
        print(error.strerror)
"""
    run = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert run.stdout == "File too large\n"
    assert (tmp_path / "checkpoint").read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["checkpoint"]
