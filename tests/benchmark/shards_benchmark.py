#!/usr/bin/env python3
"""A pool over several servers beside the same pool on one server, on the same cores.

One server has as many workers as the cores of this machine. The others, one worker each, share a
pool. The learner steps both pools in turns of half a second, random actions ahead of time, one
request at a time, so that all are equally disturbed.

    rate    environment steps per second of the pool over several servers, median of the rounds
    ratio   that rate divided by that of the single server, median of the rounds
    pause   longest step after a server was killed, seconds
"""

from __future__ import annotations

import argparse
import os
import signal
import statistics
import time
from contextlib import ExitStack

import numpy as np

from procgen_client import Pool, ServerProcess

_TURN_S = 0.5


def _rate(pool: Pool, actions: np.ndarray, place: int) -> tuple[float, int]:
    """Returns steps per second of a turn, and the next row of `actions`."""
    begin = time.perf_counter()
    count = 0
    while time.perf_counter() - begin < _TURN_S:
        pool.step(actions[(place + count) % len(actions)])
        count += 1
    return count * pool.env_count / (time.perf_counter() - begin), place + count


def _rates(pools: list[Pool], actions: np.ndarray, rounds: int) -> list[list[float]]:
    places = [0] * len(pools)
    rates: list[list[float]] = [[] for _ in pools]
    for _ in range(rounds):
        for i, pool in enumerate(pools):
            rate, places[i] = _rate(pool, actions, places[i])
            rates[i].append(rate)
    return [each[1:] for each in rates]  # The first round warms up.


def _longest_step(pool: Pool, actions: np.ndarray) -> float:
    longest = 0.0
    for row in actions[:200]:
        begin = time.perf_counter()
        pool.step(row)
        longest = max(longest, time.perf_counter() - begin)
    return longest


def main() -> None:
    """Measures and prints a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--game", default="bigfish")
    parser.add_argument("--env_count", type=int, default=256)
    parser.add_argument("--servers", type=int, default=3)
    parser.add_argument("--rounds", type=int, default=21)
    arguments = parser.parse_args()
    options = {"distribution_mode": "easy", "rand_seed": 1}
    shape = (512, arguments.env_count)
    actions = np.random.default_rng(0).integers(0, 15, shape).astype(np.int32)
    with ExitStack() as stack:
        cores = len(os.sched_getaffinity(0))
        single = stack.enter_context(ServerProcess(workers=cores))
        several = [
            stack.enter_context(ServerProcess(workers=1)) for _ in range(arguments.servers)
        ]
        addresses = [single.address, ",".join(each.address for each in several)]
        one, sharded = (
            stack.enter_context(
                Pool(arguments.game, arguments.env_count, server=address, **options)
            )
            for address in addresses
        )
        of_one, of_several = _rates([one, sharded], actions, arguments.rounds)
        ratios = [b / a for a, b in zip(of_one, of_several, strict=True)]
        os.kill(several[-1].process_id, signal.SIGKILL)
        print(f"{arguments.game}, {arguments.env_count} environments, {cores} cores")
        print("servers    rate   ratio   pause")
        print(
            f"{arguments.servers:7} {statistics.median(of_several):7.0f}"
            f" {statistics.median(ratios):7.2f} {_longest_step(sharded, actions):7.2f}"
        )


if __name__ == "__main__":
    main()
