#!/usr/bin/env python3
"""Prints the table of environment steps per second that the root's README.md shows.

Usage: throughput_report.py BIN [--games GAME...] [--seconds S]

BIN is the folder of programs of a release build, such as build/release/bin. Columns are the engine
in C++, Python in the process, and Python over TCP; rows are games and modes, on one core and on
two. Server and learner share the cores. Each figure is the best of several rounds, with 64
environments, random actions, and every observation received.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from procgen_client import Pool, ProcgenVectorEnv, ServerProcess

_ENV_COUNT = 64
_MODES = ("easy", "hard")
_CORES = (1, 2)
_ROUNDS = 5
_WARM_UP_STEPS = 100
_ACTION_ROWS = 1009  # Drawn in advance; odd, so that each half gets all of them.

Case = tuple[str, str, int]  # Game, mode, cores.


def engine_rates(programs: Path, games: list[str], seconds: float) -> dict[Case, float]:
    """Returns the engine's environment steps per second."""
    rates = {}
    for cores in _CORES:
        cases = f"step/({'|'.join(games)})/({'|'.join(_MODES)})"
        pattern = f"{cases}/workers:{cores}/drawn:1/art:built-in"
        output = subprocess.run(
            [
                *_pinned(cores),
                programs / "procgen-benchmark-engine",
                f"--benchmark_filter={pattern}",
                f"--benchmark_min_time={seconds * _ROUNDS}",
                "--benchmark_format=json",
            ],
            stdout=subprocess.PIPE,
            check=True,
        ).stdout
        for run in json.loads(output)["benchmarks"]:
            _, game, mode, *_ = run["name"].split("/")
            rates[game, mode, cores] = run["items_per_second"]
    return rates


def process_rate(case: Case, seconds: float) -> float:
    """Returns the environment steps per second of ProcgenVectorEnv in this process."""
    game, mode, cores = case
    os.sched_setaffinity(0, range(cores))
    with ProcgenVectorEnv(game, _ENV_COUNT, distribution_mode=mode, rand_seed=0) as env:
        shape = (_ACTION_ROWS, _ENV_COUNT)
        actions = itertools.cycle(np.random.default_rng(0).integers(0, 15, shape, dtype=np.int32))
        env.reset()
        return _best_rate(lambda: env.step(next(actions)), seconds)


def server_rate(server: Path, case: Case, seconds: float) -> float:
    """Returns the environment steps per second of a learner that sends one half ahead."""
    game, mode, cores = case
    os.sched_setaffinity(0, range(cores))
    with (
        ServerProcess(server, flags=[f"--workers={cores}"]) as process,
        Pool(game, _ENV_COUNT, server=process, distribution_mode=mode, rand_seed=0) as pool,
    ):
        halves = (0, _ENV_COUNT // 2)
        shape = (_ACTION_ROWS, _ENV_COUNT // 2)
        actions = itertools.cycle(np.random.default_rng(0).integers(0, 15, shape, dtype=np.int32))
        for half in halves:
            pool.send_step(next(actions), first_env=half, env_count=_ENV_COUNT // 2)

        def step() -> None:
            for half in halves:
                pool.receive()
                pool.send_step(next(actions), first_env=half, env_count=_ENV_COUNT // 2)

        return _best_rate(step, seconds)


def _best_rate(step: Callable[[], object], seconds: float) -> float:
    for _ in range(_WARM_UP_STEPS):
        step()
    return max(_round_rate(step, seconds) for _ in range(_ROUNDS))


def _round_rate(step: Callable[[], object], seconds: float) -> float:
    begin, count = time.perf_counter(), 0
    while (elapsed := time.perf_counter() - begin) < seconds:
        step()
        count += 1
    return count * _ENV_COUNT / elapsed


def _pinned(cores: int) -> list[str]:
    return ["taskset", "--cpu-list", ",".join(map(str, range(cores)))]


def table(rates: dict[str, dict[Case, float]]) -> str:
    """Returns the rates as a table in Markdown: a row per case, in steps per second."""
    lines = [["game and levels", "cores", *rates], ["---"] * (len(rates) + 2)]
    for game, mode, cores in sorted(rates["engine"]):
        name = f"{game}, {mode}" if cores == _CORES[0] else ""
        cells = (f"{round(by_case[game, mode, cores], -3):,.0f}" for by_case in rates.values())
        lines.append([name, str(cores), *cells])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", type=Path, metavar="BIN")
    parser.add_argument("--games", nargs=2, default=["bigfish", "ninja"])
    parser.add_argument("--seconds", type=float, default=0.3, help="length of a round")
    arguments = parser.parse_args()
    games, seconds = arguments.games, arguments.seconds
    rates = {"engine": engine_rates(arguments.programs, games, seconds)}
    all_cores = os.sched_getaffinity(0)
    server = arguments.programs / "procgen-server"
    ways = {
        "Python, in the process": lambda case: process_rate(case, seconds),
        "Python, TCP": lambda case: server_rate(server, case, seconds),
    }
    for way, rate in ways.items():
        rates[way] = {}
        for case in rates["engine"]:
            rates[way][case] = rate(case)
            os.sched_setaffinity(0, all_cores)
    print(table(rates))


if __name__ == "__main__":
    main()
