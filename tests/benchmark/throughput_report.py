#!/usr/bin/env python3
"""Prints environment steps per second as a table.

Usage: throughput_report.py BIN [--games GAME...] [--modes MODE...] [--cores N...]
                            [--environments N] [--ways WAY...] [--seconds S]

BIN is the folder of programs of a release build, such as build/release/bin. Columns are ways to
step a pool; rows are games and modes, by number of cores. Servers and learner share the cores. Each
figure is the best of several rounds, with random actions and every observation received. The
defaults print the table of the root's README.md.

    engine      in C++, always 64 environments, on one core or two
    process     ProcgenVectorEnv in this process
    TCP         a pool on a server, whose learner sends one half of the environments ahead
    delta_zstd  the same with this encoding
    servers     the same over a server of one worker per core
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import subprocess
import time
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from pathlib import Path

import numpy as np

from procgen_client import Pool, ProcgenVectorEnv, ServerProcess

_ROUNDS = 5
_WARM_UP_STEPS = 100
_ACTION_ROWS = 1009  # Drawn in advance; odd, so that each half gets all of them.

Case = tuple[str, str, int]  # Game, mode, cores.


def engine_rate(programs: Path, case: Case, _: int, seconds: float) -> float:
    """Returns the engine's environment steps per second."""
    game, mode, cores = case
    output = subprocess.run(
        [
            programs / "procgen-benchmark-engine",
            f"--benchmark_filter=step/{game}/{mode}/workers:{cores}/drawn:1/art:built-in",
            f"--benchmark_min_time={seconds * _ROUNDS}",
            "--benchmark_format=json",
        ],
        stdout=subprocess.PIPE,
        check=True,
    ).stdout
    return json.loads(output)["benchmarks"][0]["items_per_second"]


def process_rate(_: Path, case: Case, env_count: int, seconds: float) -> float:
    """Returns the environment steps per second of ProcgenVectorEnv in this process."""
    game, mode, _cores = case
    with ProcgenVectorEnv(game, env_count, distribution_mode=mode, rand_seed=0) as env:
        actions = _actions(env_count)
        env.reset()
        return _best_rate(lambda: env.step(next(actions)), env_count, seconds)


def server_rate(
    programs: Path,
    case: Case,
    env_count: int,
    seconds: float,
    encoding: str = "raw",
    shards: bool = False,
) -> float:
    """Returns the environment steps per second of a learner that sends one half ahead."""
    game, mode, cores = case
    with ExitStack() as stack:
        servers = [
            stack.enter_context(
                ServerProcess(
                    programs / "procgen-server", flags=[f"--workers={1 if shards else cores}"]
                )
            )
            for _ in range(cores if shards else 1)
        ]
        address = ",".join(server.address for server in servers)
        options = {"distribution_mode": mode, "rand_seed": 0, "encoding": encoding}
        pool = stack.enter_context(Pool(game, env_count, server=address, **options))
        half = env_count // 2
        actions = _actions(half)
        for first in (0, half):
            pool.send_step(next(actions), first_env=first, env_count=half)

        def step() -> None:
            for first in (0, half):
                pool.receive()
                pool.send_step(next(actions), first_env=first, env_count=half)

        return _best_rate(step, 2 * half, seconds)


_WAYS: dict[str, tuple[str, Callable[[Path, Case, int, float], float]]] = {
    "engine": ("engine", engine_rate),
    "process": ("Python, in the process", process_rate),
    "TCP": ("Python, TCP", server_rate),
    "delta_zstd": ("Python, TCP, delta_zstd", partial(server_rate, encoding="delta_zstd")),
    "servers": ("Python, TCP, a server per core", partial(server_rate, shards=True)),
}


def _actions(env_count: int) -> itertools.cycle:
    shape = (_ACTION_ROWS, env_count)
    return itertools.cycle(np.random.default_rng(0).integers(0, 15, shape, dtype=np.int32))


def _best_rate(step: Callable[[], object], env_count: int, seconds: float) -> float:
    for _ in range(_WARM_UP_STEPS):
        step()
    return max(_round_rate(step, env_count, seconds) for _ in range(_ROUNDS))


def _round_rate(step: Callable[[], object], env_count: int, seconds: float) -> float:
    begin, count = time.perf_counter(), 0
    while (elapsed := time.perf_counter() - begin) < seconds:
        step()
        count += 1
    return count * env_count / elapsed


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("programs", type=Path, metavar="BIN")
    parser.add_argument("--games", nargs="+", default=["bigfish", "ninja"])
    parser.add_argument("--modes", nargs="+", default=["easy", "hard"])
    parser.add_argument("--cores", nargs="+", type=int, default=[1, 2])
    parser.add_argument("--environments", type=int, default=64)
    parser.add_argument("--ways", nargs="+", default=["engine", "process", "TCP"], choices=_WAYS)
    parser.add_argument("--seconds", type=float, default=0.3, help="length of a round")
    arguments = parser.parse_args()
    ways = [_WAYS[name] for name in arguments.ways]
    print(f"| game and levels | cores | {' | '.join(title for title, _ in ways)} |")
    print(f"| --- | --- |{' --- |' * len(ways)}")
    all_cores = sorted(os.sched_getaffinity(0))
    for game, mode in itertools.product(arguments.games, arguments.modes):
        for cores in arguments.cores:
            os.sched_setaffinity(0, all_cores[:cores])  # Of this process and its children.
            rates = [
                rate(arguments.programs, (game, mode, cores), arguments.environments,
                     arguments.seconds)
                for _, rate in ways
            ]  # fmt: skip
            name = f"{game}, {mode}" if cores == arguments.cores[0] else ""
            cells = (f"{round(rate, -3):,.0f}" for rate in rates)
            print(f"| {name} | {cores} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
