#!/usr/bin/env python3
"""The rate of a pool in the process on a machine whose cores other programs use.

Compares files of the library. Each has a process of its own; they take turns in random order, alone
and beside twice as many busy loops as there are cores. All figures are medians over the rounds:

    rate          environment steps per second alone
    alone         this rate divided by that of the first library
    share         the rate beside the loops divided by the fair share of the rate alone, which is
                  cores / (threads of the pool + loops)
    single_share  the same for a pool that has no threads beside the caller. Nobody waits there, so
                  this is the yardstick: the rest are caches that the loops' time slices empty
"""

from __future__ import annotations

import argparse
import os
import random
import statistics
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

_CASES = [(game, mode, count, num_threads)
          for game, mode in (("bigfish", "easy"), ("ninja", "hard"))
          for count in (64, 256)
          for num_threads in (-1, 0)]  # fmt: skip
_CORES = len(os.sched_getaffinity(0))
_LOOP = [sys.executable, "-c", "while True: pass"]


def _work(library: Path) -> None:
    """A contestant: answers each line `case seconds` with its rate."""
    from library_pool import LibraryPool

    pools = [LibraryPool(library, *case) for case in _CASES]
    generator = np.random.default_rng(1)
    actions = [generator.integers(0, 15, (512, case[2]), np.int32) for case in _CASES]
    for line in sys.stdin:
        case, seconds = line.split()
        pool, choices, count = pools[int(case)], actions[int(case)], 0
        begin = time.perf_counter()
        while time.perf_counter() < begin + float(seconds):
            pool.step(choices[count % len(choices)])
            count += 1
        print(count * choices.shape[1] / (time.perf_counter() - begin), flush=True)


class _Contestant:
    def __init__(self, library: Path) -> None:
        self._process = subprocess.Popen(
            [sys.executable, __file__, "--work", library],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip

    def rate(self, case: int, seconds: float) -> float:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"{case} {seconds}\n")
        self._process.stdin.flush()
        return float(self._process.stdout.readline())

    def close(self) -> None:
        self._process.communicate()


def _turn(contestants: list[_Contestant], case: int, seconds: float) -> list[float]:
    """The rate of each, one after the other in random order."""
    order = random.sample(contestants, len(contestants))
    rates = {each: each.rate(case, seconds) for each in order}
    return [rates[each] for each in contestants]


def _measure(
    contestants: list[_Contestant], case: int, rounds: int, seconds: float
) -> tuple[list[list[float]], list[list[float]]]:
    """The rates [rounds][contestants] alone, and beside busy loops."""
    alone, busy = [], []
    for _ in range(rounds):
        alone.append(_turn(contestants, case, seconds))
        loops = [subprocess.Popen(_LOOP) for _ in range(2 * _CORES)]
        time.sleep(0.2)  # until they have started
        busy.append(_turn(contestants, case, seconds))
        for loop in loops:
            loop.kill()
            loop.wait()
    return alone, busy


def main() -> None:
    """Prints a table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("libraries", nargs="*", type=Path, metavar="LIBPROCGEN")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--seconds", type=float, default=0.5, help="of one turn")
    parser.add_argument("--work", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.work:
        _work(arguments.work)
        return
    contestants = [_Contestant(library) for library in arguments.libraries]
    print("| game | environments | library | rate | alone | share | single_share |")
    print("| --- | ---: | --- | ---: | ---: | ---: | ---: |")
    for case in range(0, len(_CASES), 2):
        game, mode, count, _ = _CASES[case]
        measured = [
            _measure(contestants, case + i, arguments.rounds, arguments.seconds) for i in (0, 1)
        ]
        alone = measured[0][0]
        for i, library in enumerate(arguments.libraries):
            rate = statistics.median(row[i] for row in alone)
            ratio = statistics.median(row[i] / row[0] for row in alone)
            shares = []
            for (free, busy), threads in zip(measured, (_CORES, 1)):
                fair = _CORES / (threads + 2 * _CORES)
                shares.append(statistics.median(b[i] / a[i] for a, b in zip(free, busy)) / fair)
            print(
                f"| {game}, {mode} | {count} | {library} | {rate:,.0f} | {ratio:.2f} "
                f"| {shares[0]:.2f} | {shares[1]:.2f} |",
                flush=True,
            )
    for contestant in contestants:
        contestant.close()


if __name__ == "__main__":
    main()
