#!/usr/bin/env python3
"""Steps each game, in this process and on a server, and draws an image. See quickstart.sh."""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import mosaic
import numpy as np

from procgen_client import ACTION_COUNT, Client, Pool, ProcgenError, ServerProcess, catalog
from procgen_client.tools.server_process import BINARY_VARIABLE

_PICTURES_OF_A_GAME = 6
_PICTURE_MODES = ("easy", "hard")
_PICTURE_SIZE_PX = 256
# Before an image is taken: number of actions, and steps per action, so that agents move around.
# RIGHT and RIGHT+UP are more frequent, since platform games extend to the right.
_PICTURE_ACTIONS = 30
_PICTURE_ACTION_STEPS = 5
_PICTURE_ACTION_ODDS = np.array([1, 1, 1, 1, 1, 1, 1, 4, 4, 1, 1, 1, 1, 1, 1]) / 21
_SECONDS_BETWEEN_REPORTS = 0.1
# Loopback, on a free port.
_PAGES = "--web_address=127.0.0.1:0"
# The program that keeps stepping with --keep, so that there is something to watch.
_KEPT_LEARNER = Path(__file__).with_name("quickstart_learner.py")


@dataclass
class Result:
    """The result of stepping one game."""

    name: str
    description: str
    rates: list[float]  # Environment steps per second, in this process and on the server.
    frames: list[np.ndarray]  # uint8 [side, side, 3] each


class Progress:
    """A progress line: rewritten in place on a terminal, otherwise one line per game."""

    def __init__(self, game_count: int) -> None:
        """Starts at 0 of game_count games."""
        self._game_count = game_count
        self._games_done = 0
        self._terminal = sys.stdout.isatty()

    def show(self, name: str, fraction: float, rates: list[float]) -> None:
        """Shows a running game, after `fraction` of its time."""
        if self._terminal:
            filled = round(24 * min(1.0, fraction))
            bar = "█" * filled + "░" * (24 - filled)
            self._write(f"\r\033[K{self._line(name, rates)}  {bar}")

    def done(self, name: str, rates: list[float]) -> None:
        """Shows a finished game."""
        start = "\r\033[K" if self._terminal else ""
        self._write(f"{start}{self._line(name, rates)}\n")
        self._games_done += 1

    def _line(self, name: str, rates: list[float]) -> str:
        count = f"[{self._games_done + 1:2}/{self._game_count}]"
        return f"{count} {name:<12}" + "".join(f" {rate:>11,.0f} steps/s" for rate in rates)

    def _write(self, text: str) -> None:
        sys.stdout.write(text)
        sys.stdout.flush()


def run_game(
    client: Client, name: str, description: str, arguments: argparse.Namespace, progress: Progress
) -> Result:
    """Steps one game with random actions, in this process and then on a server."""
    rates: list[float] = []
    for server in (None, client):
        with Pool(name, arguments.environments, server=server, rand_seed=0) as pool:
            rates.append(
                step_halves(
                    pool,
                    arguments.seconds,
                    lambda fraction, rate: progress.show(name, fraction, [*rates, rate]),
                )
            )
    progress.done(name, rates)
    return Result(name, description, rates, take_pictures(name))


def step_halves(
    pool: Pool, duration: float, progress: Callable[[float, float], None]
) -> float:
    """Steps a pool, one half after the other, with random actions.

    Args:
        pool: The pool.
        duration: In seconds.
        progress: Called with the fraction of the duration, and the rate.

    Returns:
        Environment steps per second.
    """
    rng = np.random.default_rng(0)
    pool.observe()  # The first observations take longer: art is unpacked on first use.
    middle = pool.env_count // 2
    halves = ((0, middle), (middle, pool.env_count - middle))
    # While the values of one half are awaited, the other is stepped.
    for first, count in halves:
        pool.send_observe(first_env=first, env_count=count)
    begin = reported = time.perf_counter()
    step_count = 0
    while (now := time.perf_counter()) < begin + duration:
        for first, count in halves:
            pool.receive()
            actions = rng.integers(0, ACTION_COUNT, count)
            pool.send_step(actions, first_env=first, env_count=count)
            step_count += count
        if now >= reported + _SECONDS_BETWEEN_REPORTS:
            reported = now
            progress((now - begin) / duration, step_count / (now - begin))
    for _ in halves:
        pool.receive()
    return step_count / (time.perf_counter() - begin)


def take_pictures(name: str) -> list[np.ndarray]:
    """Steps a few environments, some easy, some hard, and returns large images of them."""
    rng = np.random.default_rng(1)
    pictures: list[np.ndarray] = []
    for seed, mode in enumerate(_PICTURE_MODES):
        count = _PICTURES_OF_A_GAME // len(_PICTURE_MODES)
        with Pool(name, count, distribution_mode=mode, rand_seed=seed) as pool:
            for _ in range(_PICTURE_ACTIONS):
                actions = rng.choice(ACTION_COUNT, count, p=_PICTURE_ACTION_ODDS)
                pool.step(actions, repeat_count=_PICTURE_ACTION_STEPS, observe=False)
            pictures += pool.render(size_px=_PICTURE_SIZE_PX)
    return pictures


def print_table(results: list[Result], env_count: int) -> None:
    """Prints the rate of each game in both places."""
    width = max(len("steps/s"), *(len(result.name) for result in results))
    rule = f"{'─' * width}  {'─' * 15}  {'─' * 15}"
    print(f"\n{'steps/s':<{width}}  {'in this process':>15}  {'on the server':>15}\n{rule}")
    for result in results:
        print(f"{result.name:<{width}}" + "".join(f"  {rate:>15,.0f}" for rate in result.rates))
    print(
        f"{rule}\n{env_count} environments of each game in hard mode, with observations, from "
        "Python on this machine:\nin the process, and over gRPC on a server\n"
    )


@dataclass
class Servers:
    """The started servers."""

    processes: list[ServerProcess]
    pages: list[str]  # URL of each one's web pages.

    @property
    def addresses(self) -> str:
        """All addresses, separated by commas: learners spread their pools over them."""
        return ",".join(server.address for server in self.processes)

    def stop(self) -> None:
        """Stops all."""
        for server in self.processes:
            server.stop()


def start_servers(arguments: argparse.Namespace, log_path: Path) -> Servers:
    """Starts the servers for the arguments and waits until they are ready."""
    logs = [log_path]
    logs += [log_path.with_suffix(f".{i + 1}.log") for i in range(1, arguments.nodes)]
    with contextlib.ExitStack() as started:  # Stops them on errors.
        processes = [
            started.enter_context(ServerProcess(arguments.binary, [_PAGES], log_path=log))
            for log in logs
        ]
        started.pop_all()
    return Servers(processes, [page_address(log) for log in logs])


def page_address(log_path: Path) -> str:
    """Returns the URL of a server's web pages, from its log."""
    address = re.search(r" web=(\S+)", log_path.read_text())
    assert address is not None
    return address.group(1)


def start_learner(address: str) -> int:
    """Starts a program that steps a pool until the server stops; returns its process id."""
    command = [sys.executable, str(_KEPT_LEARNER), address]
    return subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    ).pid


def how_to_connect(servers: Servers, learner: int, log_path: Path) -> str:
    """Describes how to use, watch and stop servers that keep running."""
    package = shlex.quote(str(Path(__file__).resolve().parents[1] / "clients/python"))
    address = servers.addresses
    subject = "servers keep" if len(servers.processes) > 1 else "server keeps"
    process_ids = [server.process_id for server in servers.processes]
    text = f"""The {subject} running at {address} (log: {log_path}).

See it:   {" ".join(servers.pages)}    (watch, play, replay, browse levels)
Connect:  PYTHONPATH={package} {shlex.quote(sys.executable)} -i -c \\
            'from procgen_client import *; env = ProcgenVectorEnv("coinrun", server="{address}")'
Stop:     kill {" ".join(map(str, [*process_ids, learner]))}
"""
    if len(process_ids) > 1:
        text += f"Test it:  kill -9 {process_ids[-1]}    (kills a server; learners see a pause)\n"
    return text


def demonstrate(address: str, arguments: argparse.Namespace) -> None:
    """Steps all games, prints the table and writes the image."""
    games = catalog()["games"]
    print(
        f"== Stepping {arguments.environments} environments of each of {len(games)} games, "
        f"{arguments.seconds:g} s each: in this process, and on {arguments.nodes} "
        f"server{'s' if arguments.nodes > 1 else ''}"
    )
    progress = Progress(len(games))
    with Client(address) as client:
        results = [
            run_game(client, game["name"], game["description"], arguments, progress)
            for game in games
        ]
    print_table(results, arguments.environments)
    rows = [
        mosaic.Row(result.name, result.description, [mosaic.Picture(f) for f in result.frames])
        for result in results
    ]
    mosaic.draw(rows, size_px=_PICTURE_SIZE_PX).save(arguments.output)
    print(f"The games: {arguments.output.resolve()}")


def main() -> int:
    """Runs the program and returns its exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--binary", help=f"the server (default: {BINARY_VARIABLE}, else PATH)")
    parser.add_argument(
        "--seconds", type=float, default=1, help="seconds of stepping per game and place"
    )
    parser.add_argument("--environments", type=int, default=64, help="environments per game")
    parser.add_argument("--output", type=Path, default="quickstart.png", help="the image, a .png")
    parser.add_argument("--log", type=Path, default="server.log", help="log file of the server")
    parser.add_argument("--keep", action="store_true", help="leave the server running")
    parser.add_argument("--nodes", type=int, default=1, help="number of servers")
    arguments = parser.parse_args()

    # Signals raise exceptions, so that cleanup runs.
    for end in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(end, lambda number, _: sys.exit(128 + number))

    log_path = arguments.log.resolve()
    log_path.unlink(missing_ok=True)  # A kept server continues to write to the old file.
    try:
        servers = start_servers(arguments, log_path)
    except (OSError, ProcgenError) as error:
        print(f"quickstart: {error}", file=sys.stderr)
        return 1
    keep = False
    try:
        print(f"== See it in a browser: {' '.join(servers.pages)}", flush=True)
        demonstrate(servers.addresses, arguments)
        keep = arguments.keep
    except KeyboardInterrupt:
        print("\nStopped.", file=sys.stderr)
        return 130
    except ProcgenError as error:
        print(f"\nquickstart: {error}\nThe server's log: {log_path}", file=sys.stderr)
        return 1
    finally:
        if not keep:
            servers.stop()
    if keep:
        learner = start_learner(servers.addresses)
        print(how_to_connect(servers, learner, log_path))
    return 0


if __name__ == "__main__":
    sys.exit(main())
