#!/usr/bin/env python3
"""Demonstrates a server: steps each game, prints the rate, draws an image. See quickstart.sh."""

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
from dataclasses import dataclass
from pathlib import Path

import mosaic
import numpy as np

from procgen_client import ACTION_COUNT, Client, ProcgenError, ServerProcess
from procgen_client.errors import UnavailableError
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
_SECONDS_UNTIL_NODES_MEET = 30
# Loopback, on a free port.
_PAGES = "--web_address=127.0.0.1:0"
# The program that keeps stepping with --keep, so that there is something to watch.
_KEPT_LEARNER = Path(__file__).with_name("quickstart_learner.py")


@dataclass
class Result:
    """The result of stepping one game."""

    name: str
    description: str
    step_count: int  # Environment steps.
    seconds: float
    transport: str  # "shared_memory" or "stream".
    frames: list[np.ndarray]  # uint8 [side, side, 3] each

    @property
    def steps_per_second(self) -> float:
        """Environment steps per second."""
        return self.step_count / self.seconds


class Progress:
    """A progress line: rewritten in place on a terminal, otherwise one line per game."""

    def __init__(self, game_count: int) -> None:
        """Starts at 0 of game_count games."""
        self._game_count = game_count
        self._games_done = 0
        self._terminal = sys.stdout.isatty()

    def show(self, name: str, fraction: float, steps_per_second: float) -> None:
        """Shows a running game, after `fraction` of its time."""
        if self._terminal:
            filled = round(24 * min(1.0, fraction))
            bar = "█" * filled + "░" * (24 - filled)
            self._write(f"\r\033[K{self._line(name, steps_per_second)}  {bar}")

    def done(self, name: str, steps_per_second: float) -> None:
        """Shows a finished game."""
        start = "\r\033[K" if self._terminal else ""
        self._write(f"{start}{self._line(name, steps_per_second)}\n")
        self._games_done += 1

    def _line(self, name: str, steps_per_second: float) -> str:
        count = f"[{self._games_done + 1:2}/{self._game_count}]"
        return f"{count} {name:<12} {steps_per_second:>12,.0f} steps/s"

    def _write(self, text: str) -> None:
        sys.stdout.write(text)
        sys.stdout.flush()


def run_game(
    client: Client, name: str, description: str, arguments: argparse.Namespace, progress: Progress
) -> Result:
    """Steps one game with random actions, one half of the pool after the other.

    Raises:
        ProcgenError: One server, whose memory the client cannot share: a build without the native
            module, or no space. A fleet server has no memory to share.
    """
    rng = np.random.default_rng(0)
    transport = "stream" if arguments.nodes else "shared_memory"
    with client.create_pool(
        name, arguments.environments, transport=transport, rand_seed=0
    ) as pool:
        pool.observe()  # The first observations take longer: art is unpacked on first use.
        middle = pool.env_count // 2
        halves = ((0, middle), (middle, pool.env_count - middle))
        # While the answer of one half is in flight, the server steps the other.
        for first, count in halves:
            pool.send_observe(first_env=first, env_count=count)
        begin = reported = time.perf_counter()
        step_count = 0
        while (now := time.perf_counter()) < begin + arguments.seconds:
            for first, count in halves:
                pool.receive()
                actions = rng.integers(0, ACTION_COUNT, count)
                pool.send_step(actions, first_env=first, env_count=count)
                step_count += count
            if now >= reported + _SECONDS_BETWEEN_REPORTS:
                reported = now
                elapsed = now - begin
                progress.show(name, elapsed / arguments.seconds, step_count / elapsed)
        for _ in halves:
            pool.receive()
        seconds = time.perf_counter() - begin
        frames = take_pictures(client, name)
        result = Result(name, description, step_count, seconds, pool.transport, frames)
    progress.done(name, result.steps_per_second)
    return result


def take_pictures(client: Client, name: str) -> list[np.ndarray]:
    """Steps a few environments, some easy, some hard, and returns images of them.

    These are large and antialiased if the server can draw so, otherwise the observations.
    """
    rng = np.random.default_rng(1)
    pictures: list[np.ndarray] = []
    for seed, mode in enumerate(_PICTURE_MODES):
        count = _PICTURES_OF_A_GAME // len(_PICTURE_MODES)
        with client.create_pool(name, count, distribution_mode=mode, rand_seed=seed) as pool:
            for _ in range(_PICTURE_ACTIONS):
                actions = rng.choice(ACTION_COUNT, count, p=_PICTURE_ACTION_ODDS)
                pool.step(actions, repeat_count=_PICTURE_ACTION_STEPS, observe=False)
            if client.catalog().features.render:
                pictures += pool.render(size_px=_PICTURE_SIZE_PX)
            else:
                pictures += list(pool.observe().observations)
    return pictures


def print_table(results: list[Result], env_count: int) -> None:
    """Prints steps per second of each game."""
    width = max(len("game"), *(len(result.name) for result in results))
    rule = f"{'─' * width}  {'─' * 12}  {'─' * 15}"
    print(f"\n{'game':<{width}}  {'steps/s':>12}  {'per environment':>15}\n{rule}")
    for result in results:
        rate = result.steps_per_second
        print(f"{result.name:<{width}}  {rate:>12,.0f}  {rate / env_count:>15,.0f}")
    transport = {"shared_memory": "shared memory", "stream": "gRPC"}[results[0].transport]
    print(
        f"{rule}\n{env_count} environments of each game in hard mode, with observations, from "
        f"Python over {transport} on this machine\n"
    )


@dataclass
class Servers:
    """The started servers: one server, or a fleet server and its nodes."""

    front: ServerProcess  # Learners connect to this one.
    nodes: list[ServerProcess]
    page: str  # URL of its web pages.

    def stop(self) -> None:
        """Stops all."""
        for server in (self.front, *self.nodes):
            server.stop()


def start_servers(arguments: argparse.Namespace, log_path: Path) -> Servers:
    """Starts the servers for the arguments and waits until they are ready."""
    if arguments.nodes == 0:
        server = ServerProcess(arguments.binary, [_PAGES], log_path=log_path)
        return Servers(server, [], page_address(log_path))
    cluster = [f"--cluster=quickstart-{os.getpid()}", "--cluster_peers=127.0.0.1"]
    with contextlib.ExitStack() as started:  # Stops them on errors.
        nodes = [
            started.enter_context(
                ServerProcess(
                    arguments.binary,
                    [*cluster, f"--node_id=node-{number}"],
                    log_path=log_path.with_suffix(f".node-{number}.log"),
                )
            )
            for number in range(1, arguments.nodes + 1)
        ]
        front = started.enter_context(
            ServerProcess(
                arguments.binary,
                [*cluster, "--fleet", "--node_id=fleet", _PAGES],
                log_path=log_path,
            )
        )
        await_nodes(front.address, arguments.nodes)
        started.pop_all()
    return Servers(front, nodes, page_address(log_path))


def page_address(log_path: Path) -> str:
    """Returns the URL of a server's web pages, from its log."""
    address = re.search(r" web=(\S+)", log_path.read_text())
    assert address is not None
    return address.group(1)


def await_nodes(address: str, node_count: int) -> None:
    """Waits until the fleet server has discovered its nodes."""
    deadline = time.monotonic() + _SECONDS_UNTIL_NODES_MEET
    with Client(address) as client:
        while (known := len(client.list_nodes().nodes) - 1) < node_count:
            if time.monotonic() > deadline:
                raise UnavailableError(
                    f"the fleet server has found {known} of {node_count} nodes within "
                    f"{_SECONDS_UNTIL_NODES_MEET} s"
                )
            time.sleep(0.05)
    print(f"== A fleet server at {address} and {node_count} nodes behind it")


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
    address = servers.front.address
    subject = "fleet server and its nodes keep" if servers.nodes else "server keeps"
    process_ids = [server.process_id for server in (servers.front, *servers.nodes)]
    process_ids.append(learner)
    text = f"""The {subject} running at {address} (log: {log_path}).

See it:   {servers.page}    (watch, play, replay, browse levels)
Connect:  PYTHONPATH={package} {shlex.quote(sys.executable)} -i -c \\
            'import procgen_client; client = procgen_client.connect("{address}")'
Stop:     kill {" ".join(map(str, process_ids))}
"""
    if servers.nodes:
        victim = servers.nodes[0].process_id
        text += f"Test it:  kill -9 {victim}    (kills a node; learners see a pause)\n"
    return text


def demonstrate(address: str, arguments: argparse.Namespace) -> None:
    """Steps all games, prints the table and writes the image."""
    with Client(address) as client:
        games = client.catalog().games
        print(
            f"== Stepping {arguments.environments} environments of each of {len(games)} games, "
            f"{arguments.seconds} s each"
        )
        progress = Progress(len(games))
        results = [
            run_game(client, game.name, game.description, arguments, progress) for game in games
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
    parser.add_argument("--seconds", type=int, default=4, help="seconds of stepping per game")
    parser.add_argument("--environments", type=int, default=64, help="environments per game")
    parser.add_argument("--output", type=Path, default="quickstart.png", help="the image, a .png")
    parser.add_argument("--log", type=Path, default="server.log", help="log file of the server")
    parser.add_argument("--keep", action="store_true", help="leave the server running")
    parser.add_argument("--nodes", type=int, default=0, help="nodes of a cluster; 0: one server")
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
        print(f"== See it in a browser: {servers.page}", flush=True)
        demonstrate(servers.front.address, arguments)
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
        learner = start_learner(servers.front.address)
        print(how_to_connect(servers, learner, log_path))
    return 0


if __name__ == "__main__":
    sys.exit(main())
