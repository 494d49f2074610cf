#!/usr/bin/env python3
"""Tells how the Python client's rate stands to what C++ gets, in one run.

Usage: python_benchmark.py SERVER CONTESTANT [--environments N] [--rounds N]

SERVER and CONTESTANT are the programs procgen-server and procgen-benchmark-contestant of one build
(preset release). Contestants take turns of 50 ms each, so that all are from the same minutes, and
of each the best turn counts, for what else runs on a machine makes a turn slower, never faster.
README.md beside this file says what is compared.
"""

from __future__ import annotations

import argparse
import subprocess
import time
from collections.abc import Callable
from contextlib import ExitStack

import numpy as np

from procgen_client import Client, Pool, ProcgenVectorEnv, ServerProcess

_GAME = "bigfish"  # The game whose steps cost least, so that the client shows.
_WORKERS = 2
_WARM_UP_STEPS = 50
_TURN_SECONDS = 0.05

Turn = Callable[[], float]  # Steps for a while; gives what a step took, in seconds.


def measure(step: Callable[[], object]) -> float:
    """Steps for a turn and gives what a step took on average, in seconds."""
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
        """Draws a hundred batches, which are used in turn."""
        self._batches = list(np.random.default_rng(0).integers(0, 15, (100, env_count)))
        self._used = 0

    def next(self) -> np.ndarray:
        """Gives the next batch: int [env_count]."""
        self._used += 1
        return self._batches[self._used % len(self._batches)]


def pool_ahead(client: Client, env_count: int, transport: str) -> Turn:
    """A pool with two requests in flight, as the contract has by default."""
    pool = client.create_pool(_GAME, env_count, distribution_mode="easy", transport=transport)
    actions = Actions(env_count)
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


def pool_waiting(client: Client, env_count: int, transport: str) -> Turn:
    """A pool whose learner waits for each answer."""
    pool = client.create_pool(_GAME, env_count, distribution_mode="easy", transport=transport)
    actions = Actions(env_count)
    warm_up(pool, actions)
    return lambda: measure(lambda: pool.step(actions.next()))


def vector_env(client: Client, env_count: int, transport: str) -> Turn:
    """The same with Gymnasium's interface."""
    env = ProcgenVectorEnv(
        _GAME,
        env_count,
        server=client,
        distribution_mode="easy",
        transport=transport,
        copy=False,
        autoreset_mode="SameStep",
    )
    actions = Actions(env_count)
    warm_up(env.pool, actions)
    return lambda: measure(lambda: env.step(actions.next()))


def warm_up(pool: Pool, actions: Actions) -> None:
    """Brings the environments from their common start to a typical mixture of states."""
    for _ in range(_WARM_UP_STEPS):
        pool.step(actions.next())


def contestant(stack: ExitStack, program: str, env_count: int, *how: str) -> Turn:
    """A learner in C++: of a pool in its own process, unless `how` has a server's address."""
    process = stack.enter_context(
        subprocess.Popen(
            [program, str(env_count), *how],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
        )
    )
    assert process.stdin is not None
    assert process.stdout is not None
    reader, writer = process.stdout, process.stdin
    if reader.readline() != "ready\n":
        raise RuntimeError(f"{program} did not start")

    def turn() -> float:
        writer.write("turn\n")
        return float(reader.readline()) / 1e6

    return turn


def compete(contestants: dict[str, Turn], rounds: int) -> dict[str, float]:
    """Lets all take their turns and gives the best of each, in seconds a step."""
    best = dict.fromkeys(contestants, float("inf"))
    for _ in range(rounds):
        for name, turn in contestants.items():
            best[name] = min(best[name], turn())
    return best


def report(best: dict[str, float], env_count: int) -> None:
    """Prints a table in Markdown."""
    print(f"| {env_count} environments of {_GAME} | us a step | of C++ in process, over TCP |")
    print("| --- | --- | --- |")
    for name, cost in best.items():
        yardstick = "C++, in process" if "shared memory" in name else "C++, TCP"
        is_yardstick = name in ("C++, in process", "C++, TCP")
        ratio = "" if is_yardstick else f"{best[yardstick] / cost:.2f}"
        print(f"| {name} | {1e6 * cost:.0f} | {ratio} |")


def main() -> None:
    """Reads the arguments, lets the contestants compete and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("server", help="the program procgen-server")
    parser.add_argument("contestant", help="the program procgen-benchmark-contestant")
    parser.add_argument("--environments", type=int, default=64, help="default: %(default)s")
    parser.add_argument("--rounds", type=int, default=40, help="default: %(default)s")
    arguments = parser.parse_args()
    count = arguments.environments
    with ExitStack() as stack:
        server = stack.enter_context(
            ServerProcess(arguments.server, [f"--workers={_WORKERS}"])
        )
        client = stack.enter_context(Client(server.address))
        program = arguments.contestant
        contestants = {
            "C++, in process": contestant(stack, program, count),
            "C++, shared memory": contestant(
                stack, program, count, server.address, "shared_memory"
            ),
            "C++, TCP": contestant(stack, program, count, server.address),
            "Python, shared memory, two in flight": pool_ahead(client, count, "shared_memory"),
            "Python, shared memory, waiting": pool_waiting(client, count, "shared_memory"),
            "ProcgenVectorEnv, shared memory": vector_env(client, count, "shared_memory"),
            "Python, TCP, two in flight": pool_ahead(client, count, "stream"),
            "Python, TCP, waiting": pool_waiting(client, count, "stream"),
            "ProcgenVectorEnv, TCP": vector_env(client, count, "stream"),
        }
        report(compete(contestants, arguments.rounds), count)


if __name__ == "__main__":
    main()
