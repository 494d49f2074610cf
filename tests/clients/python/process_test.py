"""Pools in this process: their memory, threads and interrupts."""

from __future__ import annotations

import ctypes
import gc
import os
import subprocess
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import assert_same

from procgen_client import Batch, Pool, ProcgenVectorEnv, _library
from procgen_client.batch import BatchStruct
from procgen_client.errors import AbortedError

_ROOT = Path(__file__).resolve().parents[3]
_PROGRAM = """
import numpy as np
from procgen_client import Pool
pool = Pool("coinrun", 64, num_threads=2)
pool.send_step(np.zeros(64, int), repeat_count=1000)
print("stepping", flush=True)
while True:
    pool.receive()
    pool.send_step(np.zeros(64, int), repeat_count=1000)
"""


def _actions(t: int, count: int = 4) -> list[int]:
    return [(t * 7 + i * 5 + t * i) % 16 - 1 for i in range(count)]


def _in_threads(*calls: Callable[[], object]) -> None:
    threads = [threading.Thread(target=call) for call in calls]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


@pytest.mark.parametrize(
    "struct",
    [
        _library.LevelSampler,
        _library.PoolOptions,
        _library.PoolInfo,
        _library.Object,
        _library.Reset,
        _library.NextLevel,
        _library.Annotation,
        _library.Step,
        BatchStruct,
        _library.ConnectOptions,
        _library.ServerPoolOptions,
    ],
)
def test_structs_are_those_of_the_headers(struct: type[ctypes.Structure], tmp_path: Path) -> None:
    name = f"Procgen{struct.__name__.removesuffix('Struct')}"
    fields = [field[0] for field in struct._fields_]
    facts = [
        f"(int)sizeof({name})",
        *(f"(int)offsetof({name}, {field})" for field in fields),
        *(f"(int)sizeof((({name}*)0)->{field})" for field in fields),
    ]
    (tmp_path / "layout.c").write_text(
        f"""#include <stdio.h>
        #include "clients/c/procgen_remote.h"
        int main(void) {{
          int facts[] = {{{", ".join(facts)}}};
          for (size_t i = 0; i < sizeof(facts) / sizeof(int); ++i) printf("%d ", facts[i]);
        }}"""
    )
    program = tmp_path / "layout"
    subprocess.run(["cc", "-I", _ROOT, tmp_path / "layout.c", "-o", program], check=True)
    output = subprocess.run([program], check=True, capture_output=True, text=True).stdout
    layout = [getattr(struct, field) for field in fields]
    expected = [ctypes.sizeof(struct), *(each.offset for each in layout)]
    assert [int(number) for number in output.split()] == expected + [each.size for each in layout]


def test_memory_is_used_again_when_nothing_refers_to_it() -> None:
    with Pool("maze", 4) as pool:
        kept = pool.step(_actions(0)).observations[1]  # A view keeps the memory of all.
        expected = kept.copy()
        addresses = {pool.step(_actions(t)).observations.ctypes.data for t in range(20)}
        assert len(addresses) <= 2
        assert kept.base.ctypes.data not in addresses
        np.testing.assert_array_equal(kept, expected)


def test_batches_outlive_their_pool() -> None:
    with Pool("maze", 4) as pool, Pool("maze", 4, **pool.options) as twin:
        batches = [pool.step(_actions(t), final_observations=True) for t in range(3)]
        pool.close()
        gc.collect()
        for t, batch in enumerate(batches):
            assert_same(batch, twin.step(_actions(t), final_observations=True))


def test_pools_on_threads_of_their_own_are_equal() -> None:
    results: list[list[Batch]] = []

    def play() -> None:
        with Pool("bigfish", 4, rand_seed=3, num_threads=1) as pool:
            results.append([pool.step(_actions(t)) for t in range(50)])

    _in_threads(*[play] * 4)
    assert len(results) == 4
    for batches in results[1:]:
        for one, other in zip(batches, results[0], strict=True):
            assert_same(one, other)


def test_pool_that_two_threads_use_at_once_says_so() -> None:
    aborted: list[AbortedError] = []
    with Pool("coinrun", 64) as pool:

        def play() -> None:
            for _ in range(50):
                try:
                    pool.step([4] * 64, repeat_count=100)
                except AbortedError as error:
                    aborted.append(error)

        _in_threads(play, play)
        assert aborted
        assert "another call" in str(aborted[0])
        pool.reset()
        assert pool.step([4] * 64).episode_lengths.tolist() == [1] * 64


def _resources() -> tuple[int, int, int]:
    """Numbers of threads and of open files, and resident memory in kB."""
    status = Path("/proc/self/status").read_text()
    resident = next(line for line in status.splitlines() if line.startswith("VmRSS"))
    counts = (len(os.listdir(f"/proc/self/{folder}")) for folder in ("task", "fd"))
    return (*counts, int(resident.split()[1]))  # type: ignore[return-value]


@pytest.mark.parametrize("closes", [True, False], ids=["closed", "forgotten"])
def test_many_pools_leave_no_thread_no_file_and_no_memory(closes: bool) -> None:
    def make() -> None:
        pool = Pool("coinrun", 16, num_threads=2)
        pool.step([4] * 16)
        pool.send_step([4] * 16)
        env = ProcgenVectorEnv("maze", 4)
        env.reset()
        if closes:
            pool.close()
            env.close()

    for _ in range(20):
        make()
    gc.collect()
    threads, files, memory = _resources()
    for _ in range(200):
        make()
    gc.collect()
    after = _resources()
    assert after[:2] == (threads, files)
    assert after[2] < memory + 20_000
