#!/usr/bin/env python3
"""Measures how the rate of steps scales with the server's workers.

Usage: scaling_benchmark.py SERVER WORKER [--game GAME] [--environments N] [--workers N...]
                            [--pools N...] [--turns N] [--plot FILE]

SERVER and WORKER are the programs procgen-server and procgen-benchmark-worker of one build
(preset release). Each case has a server of its own; each pool has a learner of its own, in C++,
with two requests in flight. The yardstick is a pool in the learner's process with as many workers,
measured in the same run. README.md in this folder describes the results.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
from contextlib import ExitStack
from typing import NamedTuple

from procgen_client import ServerProcess

_IN_PROCESS = "in process"
_TCP = "TCP"


class Case(NamedTuple):
    """What is measured: `pools` pools, each with its own learner, and `workers` threads."""

    place: str
    pools: int
    workers: int


class Setup(NamedTuple):
    """What all cases have in common."""

    server: str
    worker: str
    game: str
    env_count: int
    turn_count: int


def measure(setup: Setup, case: Case) -> float:
    """Returns the rate of a case, in environment steps per second over all pools."""
    command = [setup.worker, setup.game, str(setup.env_count)]
    with ExitStack() as stack:
        if case.place == _IN_PROCESS:
            command.append(f"--workers={case.workers}")
        else:
            flags = [f"--workers={case.workers}"]
            server = stack.enter_context(ServerProcess(setup.server, flags, tied=True))
            command.append(server.address)
        learners = [stack.enter_context(start(command)) for _ in range(case.pools)]
        for learner in learners:
            if learner.stdout.readline() != "ready\n":
                raise RuntimeError(f"{' '.join(command)} did not start")
        for learner in learners:  # All at once, so that the pools are stepped at the same time.
            learner.stdin.write("turn\n" * setup.turn_count)
            learner.stdin.flush()
        rates = []
        for learner in learners:
            costs = [float(learner.stdout.readline()) for _ in range(setup.turn_count)]
            rates.append(1e6 * setup.env_count / statistics.median(costs))
        return sum(rates)


def start(command: list[str]) -> subprocess.Popen[str]:
    """Starts a learner, which runs a turn of 50 ms for each line that it is given."""
    return subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
    )


def print_table(rates: dict[Case, float], worker_counts: list[int]) -> None:
    """Prints rates, and in parentheses those of one worker to which they are ratios."""
    print(f"| workers | {' | '.join(map(str, worker_counts))} |")
    print("| --- |" + " ---: |" * len(worker_counts))
    for place, pools in dict.fromkeys((case.place, case.pools) for case in rates):
        row = [rates[Case(place, pools, workers)] for workers in worker_counts]
        cells = [f"{rate / 1000:.0f}k ({rate / row[0]:.1f})" for rate in row]
        plural = "" if pools == 1 else "s"
        print(f"| {place}, {pools} pool{plural} | {' | '.join(cells)} |")


def plot(rates: dict[Case, float], game: str, path: str) -> None:
    """Draws the rates over the number of workers."""
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
    for place, pools in dict.fromkeys((case.place, case.pools) for case in rates):
        points = [(case.workers, rate) for case, rate in rates.items()
                  if (case.place, case.pools) == (place, pools)]
        label = f"{place}, {pools} pool{'' if pools == 1 else 's'}"
        axes.plot(*zip(*points, strict=True), marker="o", label=label)
    axes.set(xlabel="workers of the server", ylabel="environment steps per second", title=game)
    axes.set(xlim=(0, None), ylim=(0, None))
    axes.legend()
    axes.grid(alpha=0.3)
    figure.savefig(path, dpi=120)


def main() -> None:
    """Runs the benchmark and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("server", help="path of procgen-server")
    parser.add_argument("worker", help="path of procgen-benchmark-worker")
    parser.add_argument("--game", default="bigfish", help="default: %(default)s")
    parser.add_argument("--environments", type=int, default=256,
                        help="environments per pool; default: %(default)s")
    cores = os.cpu_count() or 1
    powers = [2**i for i in range(cores.bit_length()) if 2**i <= cores]
    parser.add_argument("--workers", type=int, nargs="+", default=powers,
                        help="default: powers of two up to the number of cores")
    parser.add_argument("--pools", type=int, nargs="+", default=[1, 4], help="default: 1 4")
    parser.add_argument("--turns", type=int, default=15,
                        help="turns of 50 ms, of which the median counts; default: %(default)s")
    parser.add_argument("--plot", metavar="FILE", help="figure of the rates; needs matplotlib")
    arguments = parser.parse_args()
    setup = Setup(arguments.server, arguments.worker, arguments.game, arguments.environments,
                  arguments.turns)
    groups = [(_IN_PROCESS, 1)]
    groups += [(_TCP, pools) for pools in arguments.pools]
    rates = {
        case: measure(setup, case)
        for place, pools in groups
        for case in (Case(place, pools, workers) for workers in arguments.workers)
    }
    print_table(rates, arguments.workers)
    if arguments.plot:
        plot(rates, arguments.game, arguments.plot)


if __name__ == "__main__":
    main()
