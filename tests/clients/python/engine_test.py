"""Pools that the engine steps in this process."""

from __future__ import annotations

import ctypes
import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from procgen_client import Client, Reset, _library
from procgen_client._engine import EnginePool
from procgen_client._engine_options import pool_options
from procgen_client.errors import (
    DataLossError,
    FailedPreconditionError,
    InvalidArgumentError,
    NotFoundError,
)
from procgen_client.options import LevelSampler

_ROOT = Path(__file__).resolve().parents[3]
_EASY = 0


def _pool(game: str = "maze", count: int = 4, **fields: object) -> EnginePool:
    fields = {"env_count": count, "distribution_mode": _EASY, "rand_seed": 3, **fields}
    options, kept = pool_options([game], **fields)
    pool = EnginePool(options)
    del kept
    return pool


def _actions(step: int, count: int = 4) -> list[int]:
    return [(step * 7 + i * 5 + step * i) % 15 for i in range(count)]


@pytest.mark.parametrize(
    ("name", "struct"),
    [
        ("ProcgenLevelSampler", _library.LevelSampler),
        ("ProcgenPoolOptions", _library.PoolOptions),
        ("ProcgenPoolInfo", _library.PoolInfo),
        ("ProcgenReset", _library.Reset),
        ("ProcgenNextLevel", _library.NextLevel),
        ("ProcgenStep", _library.Step),
        ("ProcgenBatch", _library.Batch),
    ],
)
def test_structs_are_those_of_the_header(
    name: str, struct: type[ctypes.Structure], tmp_path: Path
) -> None:
    fields = [field[0] for field in struct._fields_]
    offsets = ", ".join(f"(int)offsetof({name}, {field})" for field in fields)
    (tmp_path / "layout.c").write_text(
        f"""#include <stdio.h>
        #include "clients/c/procgen.h"
        int main(void) {{
          int facts[] = {{(int)sizeof({name}), {offsets}}};
          for (size_t i = 0; i < sizeof(facts) / sizeof(int); ++i) printf("%d ", facts[i]);
        }}"""
    )
    program = tmp_path / "layout"
    subprocess.run(["cc", "-I", _ROOT, tmp_path / "layout.c", "-o", program], check=True)
    output = subprocess.run([program], check=True, capture_output=True, text=True).stdout
    expected = [ctypes.sizeof(struct), *(getattr(struct, field).offset for field in fields)]
    assert [int(number) for number in output.split()] == expected


@pytest.mark.parametrize("game", ["bigfish", "coinrun", "ninja"])
@pytest.mark.parametrize("threads", [0, 2])
def test_batches_equal_those_of_a_server(client: Client, game: str, threads: int) -> None:
    pool = _pool(game, num_threads=threads)
    with client.create_pool(game, 4, distribution_mode="easy", rand_seed=3) as served:
        for t in range(100):
            actions = _actions(t)
            batch = pool.step(actions, final_observations=True)
            expected = served.step(actions, final_observations=True)
            for name in ("observations", "rewards", "first", "terminated", "truncated",
                         "level_seeds", "prev_level_seeds", "prev_level_complete",
                         "episode_returns", "episode_lengths"):  # fmt: skip
                np.testing.assert_array_equal(getattr(batch, name), getattr(expected, name), name)
            ended = batch.ended
            np.testing.assert_array_equal(batch.fingerprints[ended], expected.fingerprints)
            np.testing.assert_array_equal(
                batch.final_observations[ended].reshape(-1),
                expected.final_observations.reshape(-1),
            )


def test_arrays_that_are_kept_never_change() -> None:
    pool = _pool("bigfish")
    kept, copies = [], []
    for t in range(20):
        batch = pool.step(_actions(t))
        kept.append((batch.observations[:2], batch.rewards, batch.level_seeds))
        copies.append([array.copy() for array in kept[-1]])
    for arrays, expected in zip(kept, copies, strict=True):
        for array, copy in zip(arrays, expected, strict=True):
            np.testing.assert_array_equal(array, copy)


def test_memory_is_used_again_when_nothing_refers_to_it() -> None:
    pool = _pool()
    addresses = {pool.step(_actions(t)).observations.ctypes.data for t in range(20)}
    assert len(addresses) <= 2


def test_requests_are_answered_in_order_and_halves_equal_the_whole() -> None:
    whole, halves = _pool("bigfish"), _pool("bigfish", num_threads=1)
    for t in range(30):
        actions = _actions(t)
        expected = whole.step(actions)
        for first in (0, 2):
            halves.send_step(actions[first : first + 2], first_env=first, env_count=2)
        for first in (0, 2):
            batch = halves.receive()
            assert batch.first_env == first
            rows = slice(first, first + 2)
            np.testing.assert_array_equal(batch.observations, expected.observations[rows])
            np.testing.assert_array_equal(batch.rewards, expected.rewards[rows])
    with pytest.raises(FailedPreconditionError, match="no request is unanswered"):
        halves.receive()
    halves.send_step(_actions(0))
    with pytest.raises(FailedPreconditionError, match="1 requests are unanswered"):
        halves.step(_actions(0))


def test_levels_are_chosen_by_resets_next_levels_and_samplers() -> None:
    pool = _pool()
    assert pool.reset([Reset(1, level_seed=42)]).level_seeds[1] == 42
    batch = pool.step([-1] * 4, next_levels={2: 43})
    assert batch.level_seeds[2] == 43
    assert batch.terminated.all()
    batch = pool.step([4] * 4, resets=[Reset(3, level_seed=44)])
    assert batch.level_seeds[3] == 44
    pool.set_level_sampler(LevelSampler([7, 8]))
    assert set(pool.step([-1] * 4).level_seeds) <= {7, 8}
    sampled = _pool(level_sampler=LevelSampler([9], [1.0]))
    assert set(sampled.observe().level_seeds) == {9}


def test_states_continue_in_another_pool() -> None:
    pool = _pool("coinrun")
    for t in range(30):
        pool.step(_actions(t))
    states = pool.save_states()
    expected = [pool.step(_actions(t)).observations.copy() for t in range(30, 60)]
    other = _pool("coinrun", rand_seed=9)
    other.restore_states(states)
    for t in range(30, 60):
        np.testing.assert_array_equal(other.step(_actions(t)).observations, expected[t - 30])
    other.clone_states([0], [3])
    first, *_, last = other.save_states([0, 3])
    assert first == last
    with pytest.raises(DataLossError):
        other.restore_states({0: states[0][:-1]})
    with pytest.raises(InvalidArgumentError, match="states has 1 snapshots"):
        other.restore_states(states[:1])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda pool: pool.step([4]), r"actions has shape \[1\]"),
        (lambda pool: pool.step([4.0] * 4), "type float64"),
        (lambda pool: pool.step([4, 4, 4, 2**32 + 4]), "actions contains 4294967300"),
        (lambda pool: pool.step([4, 4, 4, 15]), "action 15 of environment 3"),
        (lambda pool: pool.step([4] * 4, repeat_count=1001), "repeat is 1001"),
        (lambda pool: pool.step([4] * 4, next_levels={4: 0}), "names environment 4"),
        (lambda pool: pool.observe(first_env=1, env_count=4), "4 environments from 1"),
        (lambda pool: pool.observe(env_count=5), "env_count is 5"),
        (lambda pool: pool.render(size_px=8), "size_px is 8"),
        (lambda pool: pool.reset([Reset(9)]), "names environment 9"),
    ],
)
def test_bad_arguments_are_named(call: object, message: str) -> None:
    pool = _pool()
    before = pool.save_states()
    with pytest.raises(InvalidArgumentError, match=message):
        call(pool)  # type: ignore[operator]
    assert pool.save_states() == before


def test_a_game_that_does_not_exist_is_named() -> None:
    with pytest.raises(NotFoundError, match="pong"):
        _pool("pong")


def test_a_closed_pool_says_so() -> None:
    pool = _pool()
    pool.close()
    pool.close()
    for call in (lambda: pool.step([4] * 4), pool.observe, pool.save_states, pool.render):
        with pytest.raises(FailedPreconditionError, match="closed"):
            call()


def test_a_forked_child_makes_its_own() -> None:
    pool = _pool(num_threads=2)
    child = os.fork()
    if child == 0:
        try:
            pool.step([4] * 4)
        except FailedPreconditionError as error:
            own = _pool(num_threads=2).step([4] * 4)
            os._exit(0 if "is a fork" in str(error) and own.env_count == 4 else 1)
        os._exit(2)
    _, status = os.waitpid(child, 0)
    assert status == 0
    pool.step([4] * 4)


def test_many_pools_leave_no_thread_and_no_memory() -> None:
    def resident_mb() -> float:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE") / 2**20

    for _ in range(20):
        _pool("coinrun", 16, num_threads=1).step([4] * 16)
    threads, memory = len(os.listdir("/proc/self/task")), resident_mb()
    for _ in range(200):
        _pool("coinrun", 16, num_threads=1).step([4] * 16)
    assert len(os.listdir("/proc/self/task")) <= threads
    assert resident_mb() < memory + 20


def test_threads_have_pools_of_their_own() -> None:
    def play(results: list[np.ndarray]) -> None:
        pool = _pool("bigfish")
        results.append(np.stack([pool.step(_actions(t)).observations for t in range(50)]))

    results: list[np.ndarray] = []
    threads = [threading.Thread(target=play, args=(results,)) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 4
    for other in results[1:]:
        np.testing.assert_array_equal(other, results[0])


def test_ctrl_c_ends_a_wait_at_once() -> None:
    program = """
import time
from procgen_client._engine import EnginePool
from procgen_client._engine_options import pool_options
options, kept = pool_options(["ninja"], env_count=512, num_threads=1)
pool = EnginePool(options)
pool.send_step([7] * 512, repeat_count=1000)
print("waits", flush=True)
pool.receive()
"""
    process = subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "waits\n"
    time.sleep(0.2)  # It is inside the library.
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=60)
    assert re.search(r"_library\.receive\(", error), error
    assert "KeyboardInterrupt" in error
