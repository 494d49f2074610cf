#!/usr/bin/env python3
"""Compares the Python client's rate with that of C++, in one run.

Usage: python_benchmark.py SERVER WORKER [--games GAME...] [--environments N] [--rounds N]
                           [--summary]

SERVER and WORKER are the programs procgen-server and procgen-benchmark-worker of one build
(preset release). For each game the contestants alternate in turns of 50 ms, so that all are
measured in the same minutes. The best turn of each counts, because other load makes a turn slower,
never faster. README.md in this folder describes the contestants.
"""

from __future__ import annotations

import argparse
import math
import subprocess
import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import NamedTuple

import numpy as np

from procgen_client import Client, Pool, ProcgenVectorEnv, ServerProcess

_WORKERS = 2
_OPTIONS = {"distribution_mode": "easy", "rand_seed": 0}  # The levels of the pool in process.
_AIM = 0.8
_WARM_UP_STEPS = 50
_TURN_SECONDS = 0.05

Turn = Callable[[], float]  # Steps for one turn; returns seconds per step.
Costs = dict[str, float]  # Seconds per step, by contestant.

# Reference of each contestant.
_IN_PROCESS, _CPP_TCP = "C++, in process", "C++, TCP"
_COMPETITORS = {
    "C++, shared memory": _IN_PROCESS,
    "Python, shared memory, two in flight": _IN_PROCESS,
    "Python, shared memory, waiting": _IN_PROCESS,
    "ProcgenVectorEnv, shared memory": _IN_PROCESS,
    "Python, TCP, two in flight": _CPP_TCP,
    "Python, TCP, waiting": _CPP_TCP,
    "ProcgenVectorEnv, TCP": _CPP_TCP,
}


class Case(NamedTuple):
    """The game and the size of the pool."""

    game: str
    env_count: int


class Ratios(NamedTuple):
    """A contestant's rates divided by its reference's, over the games."""

    mean: float  # Geometric.
    least: tuple[float, str]
    most: tuple[float, str]

    @classmethod
    def of(cls, competitor: str, costs: dict[str, Costs]) -> Ratios:
        """Computes them from the costs of each contestant, by game."""
        yardstick = _COMPETITORS[competitor]
        ratios = {game: by[yardstick] / by[competitor] for game, by in costs.items()}
        mean = math.exp(sum(map(math.log, ratios.values())) / len(ratios))
        ordered = sorted((ratio, game) for game, ratio in ratios.items())
        return cls(mean, ordered[0], ordered[-1])


def measure(step: Callable[[], object]) -> float:
    """Steps for one turn; returns the mean seconds per step."""
    begin = time.perf_counter()
    count = 0
    while True:
        step()
        count += 1
        elapsed = time.perf_counter() - begin
        if elapsed >= _TURN_SECONDS:
            return elapsed / count


class Actions:
    """Random actions, drawn in advance."""

    def __init__(self, env_count: int) -> None:
        """Draws a hundred batches, which are used cyclically."""
        self._batches = list(np.random.default_rng(0).integers(0, 15, (100, env_count)))
        self._used = 0

    def next(self) -> np.ndarray:
        """Returns the next batch: int [env_count]."""
        self._used += 1
        return self._batches[self._used % len(self._batches)]


def pool_ahead(stack: ExitStack, client: Client, case: Case, transport: str) -> Turn:
    """A pool with two requests in flight, the default of the protocol."""
    pool = made_pool(stack, client, case, transport)
    actions = Actions(case.env_count)
    warm_up(pool, actions)

    def exchange() -> None:
        pool.send_step(actions.next())
        pool.receive()

    def turn() -> float:
        pool.send_step(actions.next())
        cost = measure(exchange)
        pool.receive()
        return cost

    return turn


def pool_waiting(stack: ExitStack, client: Client, case: Case, transport: str) -> Turn:
    """A pool whose learner waits for each response."""
    pool = made_pool(stack, client, case, transport)
    actions = Actions(case.env_count)
    warm_up(pool, actions)
    return lambda: measure(lambda: pool.step(actions.next()))


def vector_env(stack: ExitStack, client: Client, case: Case, transport: str) -> Turn:
    """The same through Gymnasium's vector interface."""
    env = ProcgenVectorEnv(
        case.game,
        case.env_count,
        server=client,
        **_OPTIONS,
        transport=transport,
        copy=False,
        autoreset_mode="SameStep",
    )
    stack.callback(env.close)
    actions = Actions(case.env_count)
    warm_up(env.pool, actions)
    return lambda: measure(lambda: env.step(actions.next()))


def made_pool(stack: ExitStack, client: Client, case: Case, transport: str) -> Pool:
    """Creates a pool, which `stack` closes."""
    return stack.enter_context(
        client.create_pool(case.game, case.env_count, **_OPTIONS, transport=transport)
    )


def warm_up(pool: Pool, actions: Actions) -> None:
    """Steps until the environments are in a typical mixture of states."""
    for _ in range(_WARM_UP_STEPS):
        pool.step(actions.next())


def worker(stack: ExitStack, program: str, case: Case, *how: str) -> Turn:
    """A C++ learner; its pool is in its own process unless `how` has a server's address."""
    process = stack.enter_context(
        subprocess.Popen(
            [program, case.game, str(case.env_count), *how],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
        )
    )
    # Closes its input before waiting for it.
    assert process.stdin is not None
    assert process.stdout is not None
    reader, writer = process.stdout, process.stdin
    if reader.readline() != "ready\n":
        raise RuntimeError(f"{program} did not start")

    def turn() -> float:
        writer.write("turn\n")
        return float(reader.readline()) / 1e6

    return turn


def all_turns(stack: ExitStack, program: str, client: Client, case: Case) -> dict[str, Turn]:
    """Returns the contestants, each with its own pool."""
    turns = {
        _IN_PROCESS: worker(stack, program, case),
        "C++, shared memory": worker(stack, program, case, client.address, "shared_memory"),
        _CPP_TCP: worker(stack, program, case, client.address),
    }
    for name, transport in (("shared memory", "shared_memory"), ("TCP", "stream")):
        turns[f"Python, {name}, two in flight"] = pool_ahead(stack, client, case, transport)
        turns[f"Python, {name}, waiting"] = pool_waiting(stack, client, case, transport)
        turns[f"ProcgenVectorEnv, {name}"] = vector_env(stack, client, case, transport)
    return turns


def compete(turns: dict[str, Turn], rounds: int) -> Costs:
    """Runs the rounds; returns the best turn of each contestant, in seconds per step."""
    best = dict.fromkeys(turns, float("inf"))
    for _ in range(rounds):
        for name, turn in turns.items():
            best[name] = min(best[name], turn())
    return best


def print_games(costs: dict[str, Costs], env_count: int) -> None:
    """Prints a Markdown table of microseconds per step, by game and contestant."""
    names = [_IN_PROCESS, _CPP_TCP, *_COMPETITORS]
    print(f"| us per step of {env_count} environments | {' | '.join(names)} |")
    print("| --- " * (len(names) + 1) + "|")
    for game, by in costs.items():
        print(f"| {game} | {' | '.join(f'{1e6 * by[name]:.0f}' for name in names)} |")
    print()


def print_summary(costs: dict[str, Costs], env_count: int) -> None:
    """Prints the Markdown table of ratios; README.md in this folder contains some rows."""
    print("| measurement | target | result |")
    print("| --- | --- | --- |")
    for competitor, yardstick in _COMPETITORS.items():
        ratios = Ratios.of(competitor, costs)
        of = "pool in process" if yardstick == _IN_PROCESS else "C++ client"
        aim = f"{_AIM:.2f}" if "Python" in competitor or "Vector" in competitor else ""
        print(
            f"| {competitor}, {env_count} environments: rate / {of} | {aim} | {ratios.mean:.2f} "
            f"({ratios.least[1]} {ratios.least[0]:.2f}, {ratios.most[1]} {ratios.most[0]:.2f}) |"
        )


def main() -> None:
    """Runs the benchmark and prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("server", help="path of procgen-server")
    parser.add_argument("worker", help="path of procgen-benchmark-worker")
    parser.add_argument("--games", nargs="+", metavar="GAME",
                        help="games to measure; default: all")
    parser.add_argument("--environments", type=int, default=64,
                        help="environments per pool; default: %(default)s")
    # In its first turns the pool in process still decodes the images of its levels.
    parser.add_argument("--rounds", type=int, default=9,
                        help="turns of each contestant; default: %(default)s")
    parser.add_argument("--summary", action="store_true",
                        help="print only the ratios, not the table of games")
    arguments = parser.parse_args()
    count = arguments.environments
    costs: dict[str, Costs] = {}
    with (
        ServerProcess(arguments.server, [f"--workers={_WORKERS}"], tied=True) as server,
        Client(server.address) as client,
    ):
        for game in arguments.games or [game.name for game in client.catalog().games]:
            with ExitStack() as stack:
                case = Case(game, count)
                turns = all_turns(stack, arguments.worker, client, case)
                costs[game] = compete(turns, arguments.rounds)
    if not arguments.summary:
        print_games(costs, count)
    print_summary(costs, count)


if __name__ == "__main__":
    main()
