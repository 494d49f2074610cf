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
import os
import subprocess
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from procgen_client import Client, Credentials, Pool, ProcgenVectorEnv, ServerProcess, catalog

_WORKERS = 2
_OPTIONS = {"distribution_mode": "easy", "rand_seed": 0}  # The levels of the pool in process.
_WARM_UP_STEPS = 50
_TURN_SECONDS = 0.05
_CA_VARIABLE = "PROCGEN_SERVER_CA"


Turn = Callable[[], float]  # Steps for a while; returns the seconds of a step.
Costs = dict[str, float]  # Seconds of a step, by worker.


class Comparison(NamedTuple):
    """What a competitor is compared with, and how it should do at least."""

    yardstick: str
    aim: float | None = None


# How batches reach the learner, and what pools are made with for that.
_TRANSPORTS: dict[str, dict[str, Any]] = {
    "in process": {"num_threads": _WORKERS - 1},
    "TCP": {},
    "TLS": {},
    "compressed": {"encoding": "delta_zstd"},
}
_CPP_ARGUMENTS = {"compressed": ["compressed"]}
_IN_PROCESS = "C++, in process"
_COMPETITORS = {
    "Python, in process": Comparison(_IN_PROCESS, 0.95),
    "ProcgenVectorEnv, in process": Comparison(_IN_PROCESS, 0.92),
    "Python, TCP, two in flight": Comparison("C++, TCP", 0.97),
    "Python, TCP, waiting": Comparison("C++, TCP", 0.8),
    "C++, TLS": Comparison("C++, TCP"),
    "Python, TLS, two in flight": Comparison("Python, TCP, two in flight", 0.6),
    "C++, compressed": Comparison("C++, TCP"),
    "Python, compressed, two in flight": Comparison("C++, compressed", 0.95),
    "ProcgenVectorEnv, TCP": Comparison("C++, TCP", 0.8),
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
        """Takes what a step costs each worker, by game."""
        yardstick = _COMPETITORS[competitor].yardstick
        ratios = {game: by[yardstick] / by[competitor] for game, by in costs.items()}
        mean = math.exp(sum(map(math.log, ratios.values())) / len(ratios))
        ordered = sorted((ratio, game) for game, ratio in ratios.items())
        return cls(mean, ordered[0], ordered[-1])


def measure(step: Callable[[], object]) -> float:
    """Steps for a turn and returns the mean seconds of a step."""
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


def pool_ahead(stack: ExitStack, client: Client | None, case: Case, transport: str) -> Turn:
    """A pool with two requests in flight."""
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


def pool_waiting(stack: ExitStack, client: Client | None, case: Case, transport: str) -> Turn:
    """A pool whose learner waits for each response."""
    pool = made_pool(stack, client, case, transport)
    actions = Actions(case.env_count)
    warm_up(pool, actions)
    return lambda: measure(lambda: pool.step(actions.next()))


def vector_env(stack: ExitStack, client: Client | None, case: Case, transport: str) -> Turn:
    """The same through Gymnasium's vector interface."""
    env = ProcgenVectorEnv(
        case.game,
        case.env_count,
        server=client,
        **_OPTIONS,
        **_TRANSPORTS[transport],
        autoreset_mode="SameStep",
    )
    stack.callback(env.close)
    actions = Actions(case.env_count)
    warm_up(env.pool, actions)
    return lambda: measure(lambda: env.step(actions.next()))


def made_pool(stack: ExitStack, client: Client | None, case: Case, transport: str) -> Pool:
    """Makes a pool, which `stack` closes. None: in this process."""
    return stack.enter_context(
        Pool(case.game, case.env_count, server=client, **_OPTIONS, **_TRANSPORTS[transport])
    )


def warm_up(pool: Pool, actions: Actions) -> None:
    """Steps until the environments are in a typical mixture of states."""
    for _ in range(_WARM_UP_STEPS):
        pool.step(actions.next())


def worker(
    stack: ExitStack, program: str, case: Case, *how: str, ca: Path | None = None
) -> Turn:
    """A learner in C++: of a pool in its own process, unless `how` has a server's address."""
    process = stack.enter_context(
        subprocess.Popen(
            [program, case.game, str(case.env_count), *how],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
            env=os.environ if ca is None else os.environ | {_CA_VARIABLE: str(ca)},
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


class Servers(NamedTuple):
    """A server in plain text and one with TLS."""

    plain: Client
    secure: Client
    ca: Path


def start_servers(stack: ExitStack, program: str) -> Servers:
    """Starts them, until the stack ends."""
    folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256"]
        + ["-nodes", "-days", "2", "-subj", "/CN=localhost", "-addext"]
        + ["subjectAltName=DNS:localhost,IP:127.0.0.1", "-keyout", "key.pem", "-out", "ca.pem"],
        cwd=folder,
        check=True,
        stderr=subprocess.DEVNULL,
    )
    ca = folder / "ca.pem"
    tls = [f"--tls_certificate={ca}", f"--tls_key={folder}/key.pem"]
    clients = []
    for flags, credentials in (([], Credentials()), (tls, Credentials(ca=ca))):
        server = ServerProcess(program, [f"--workers={_WORKERS}", *flags], tied=True)
        stack.enter_context(server)
        clients.append(stack.enter_context(Client(server.address, credentials=credentials)))
    return Servers(*clients, ca)


def all_turns(
    stack: ExitStack, program: str, servers: Servers, case: Case
) -> dict[str, Turn]:
    """Yields the contestants, each with its own pool."""
    turns = {
        _IN_PROCESS: worker(stack, program, case),
        "Python, in process": pool_waiting(stack, None, case, "in process"),
        "ProcgenVectorEnv, in process": vector_env(stack, None, case, "in process"),
    }
    for name in ("TCP", "TLS", "compressed"):
        client, ca = (servers.secure, servers.ca) if name == "TLS" else (servers.plain, None)
        how = _CPP_ARGUMENTS.get(name, [])
        turns[f"C++, {name}"] = worker(stack, program, case, client.address, *how, ca=ca)
        makers = {
            f"Python, {name}, two in flight": pool_ahead,
            f"Python, {name}, waiting": pool_waiting,
            f"ProcgenVectorEnv, {name}": vector_env,
        }
        for competitor, make in makers.items():
            if competitor in _COMPETITORS:
                turns[competitor] = make(stack, client, case, name)
    return turns


def compete(turns: dict[str, Turn], rounds: int) -> Costs:
    """Lets all take their turns and gives the best of each."""
    taken = {name: [] for name in turns}
    for _ in range(rounds):
        for name, turn in turns.items():
            taken[name].append(turn())
    return {name: min(costs) for name, costs in taken.items()}


def print_games(costs: dict[str, Costs], env_count: int) -> None:
    """Prints in Markdown what a step costs each in each game."""
    names = [_IN_PROCESS, "C++, TCP", *_COMPETITORS]
    print(f"| us a step of {env_count} environments | {' | '.join(names)} |")
    print("| --- " * (len(names) + 1) + "|")
    for game, by in costs.items():
        print(f"| {game} | {' | '.join(f'{1e6 * by[name]:.0f}' for name in names)} |")
    print()


def print_summary(costs: dict[str, Costs], env_count: int) -> None:
    """Prints the Markdown table of ratios; README.md in this folder contains some rows."""
    print("| measurement | target | result |")
    print("| --- | --- | --- |")
    for competitor, (yardstick, aim) in _COMPETITORS.items():
        ratios = Ratios.of(competitor, costs)
        print(
            f"| {competitor}, {env_count} environments: rate, of {yardstick!r} | "
            f"{'' if aim is None else f'{aim:.2f}'} | {ratios.mean:.2f} "
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
    with ExitStack() as servers_stack:
        servers = start_servers(servers_stack, arguments.server)
        for game in arguments.games or [game["name"] for game in catalog()["games"]]:
            with ExitStack() as stack:
                turns = all_turns(stack, arguments.worker, servers, Case(game, count))
                costs[game] = compete(turns, arguments.rounds)
    if not arguments.summary:
        print_games(costs, count)
    print_summary(costs, count)


if __name__ == "__main__":
    main()
