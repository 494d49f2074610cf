#!/usr/bin/env python3
"""Shows what a server does: steps each game, tells how fast, draws a picture. See quickstart.sh."""

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
# Before a picture is taken: so many actions, each held for so many steps, so that agents get about;
# RIGHT and RIGHT+UP more often than others, since that is where platform games lie.
_PICTURE_ACTIONS = 30
_PICTURE_ACTION_STEPS = 5
_PICTURE_ACTION_ODDS = np.array([1, 1, 1, 1, 1, 1, 1, 4, 4, 1, 1, 1, 1, 1, 1]) / 21
_SECONDS_BETWEEN_REPORTS = 0.1
_SECONDS_UNTIL_NODES_MEET = 30
# Loopback, on a port that is free.
_PAGES = "--web_address=127.0.0.1:0"
# What steps on where the server is kept, so that there is something to see.
_KEPT_LEARNER = Path(__file__).with_name("quickstart_learner.py")


@dataclass
class Result:
    """What came of stepping one game."""

    name: str
    description: str
    step_count: int  # Environment steps.
    seconds: float
    frames: list[np.ndarray]  # uint8 [side, side, 3] each

    @property
    def steps_per_second(self) -> float:
        """Environment steps per second."""
        return self.step_count / self.seconds


class Progress:
    """One line that is written anew on a terminal; one line a game elsewhere."""

    def __init__(self, game_count: int) -> None:
        """Counts games up to game_count."""
        self._game_count = game_count
        self._games_done = 0
        self._terminal = sys.stdout.isatty()

    def show(self, name: str, fraction: float, steps_per_second: float) -> None:
        """Tells how a game stands; `fraction` of its time is over."""
        if self._terminal:
            filled = round(24 * min(1.0, fraction))
            bar = "█" * filled + "░" * (24 - filled)
            self._write(f"\r\033[K{self._line(name, steps_per_second)}  {bar}")

    def done(self, name: str, steps_per_second: float) -> None:
        """Tells how a game went."""
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
    """Steps one game with random actions, one half of the pool after the other."""
    rng = np.random.default_rng(0)
    with client.create_pool(name, arguments.environments, rand_seed=0) as pool:
        pool.observe()  # The first pictures take longer: art is unpacked when it is first needed.
        middle = pool.env_count // 2
        halves = ((0, middle), (middle, pool.env_count - middle))
        # While the answer of one half is on its way, the server steps the other.
        for first, count in halves:
            pool.send_observe(first_env=first, env_count=count)
        begin = reported = time.perf_counter()
        step_count = 0
        while (now := time.perf_counter()) < begin + arguments.seconds:
            for first, count in halves:
                pool.receive()
                actions = rng.integers(0, ACTION_COUNT, count)
                pool.send_step(actions, first_env=first)
                step_count += count
            if now >= reported + _SECONDS_BETWEEN_REPORTS:
                reported = now
                elapsed = now - begin
                progress.show(name, elapsed / arguments.seconds, step_count / elapsed)
        for _ in halves:
            pool.receive()
        seconds = time.perf_counter() - begin
        result = Result(name, description, step_count, seconds, take_pictures(client, name))
    progress.done(name, result.steps_per_second)
    return result


def take_pictures(client: Client, name: str) -> list[np.ndarray]:
    """Plays a few environments for a while, some easy, some hard, and gives their pictures.

    For people (large and smooth) if the server draws such, otherwise what the agents see.
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
    print(
        f"{rule}\n{env_count} environments of each game in hard mode, with pictures, from "
        "Python, over gRPC on this machine\n"
    )


@dataclass
class Servers:
    """What was started: one server, or the nodes of a cluster and before them a fleet server."""

    front: ServerProcess  # The one that learners connect to.
    nodes: list[ServerProcess]
    page: str  # Where a browser sees it.

    def stop(self) -> None:
        """Stops all."""
        for server in (self.front, *self.nodes):
            server.stop()


def start_servers(arguments: argparse.Namespace, log_path: Path) -> Servers:
    """Starts what the arguments ask for, and waits until it is ready."""
    if arguments.nodes == 0:
        server = ServerProcess(arguments.binary, [_PAGES], log_path=log_path)
        return Servers(server, [], page_address(log_path))
    cluster = [f"--cluster=quickstart-{os.getpid()}", "--cluster_peers=127.0.0.1"]
    with contextlib.ExitStack() as started:  # Stops them if anything goes wrong.
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
    """The address of the pages that a server serves, by its log."""
    address = re.search(r" web=(\S+)", log_path.read_text())
    assert address is not None
    return address.group(1)


def await_nodes(address: str, node_count: int) -> None:
    """Waits until the fleet server knows its nodes."""
    deadline = time.monotonic() + _SECONDS_UNTIL_NODES_MEET
    with Client(address) as client:
        while (known := len(client.list_nodes().nodes) - 1) < node_count:
            if time.monotonic() > deadline:
                raise UnavailableError(
                    f"of {node_count} nodes the fleet server has found {known} within "
                    f"{_SECONDS_UNTIL_NODES_MEET} s"
                )
            time.sleep(0.05)
    print(f"== A fleet server at {address} and {node_count} nodes behind it")


def start_learner(address: str) -> int:
    """Starts a program that steps a pool as long as the server is there; gives its process id."""
    command = [sys.executable, str(_KEPT_LEARNER), address]
    return subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    ).pid


def how_to_connect(servers: Servers, learner: int, log_path: Path) -> str:
    """Tells what can be done with servers that run on."""
    package = shlex.quote(str(Path(__file__).resolve().parents[1] / "clients/python"))
    address = servers.front.address
    who = "fleet server runs on with its nodes" if servers.nodes else "server runs on"
    process_ids = [server.process_id for server in (servers.front, *servers.nodes)]
    process_ids.append(learner)
    text = f"""The {who} at {address} (its log: {log_path}).

See it:   {servers.page}    (watch, play, replay, browse levels)
Connect:  PYTHONPATH={package} {shlex.quote(sys.executable)} -i -c \\
            'import procgen_client; client = procgen_client.connect("{address}")'
Stop:     kill {" ".join(map(str, process_ids))}
"""
    if servers.nodes:
        victim = servers.nodes[0].process_id
        text += f"Harm it:  kill -9 {victim}    (a node; learners notice a pause)\n"
    return text


def demonstrate(address: str, arguments: argparse.Namespace) -> None:
    """Steps all games, and writes the table and the picture."""
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
    """Runs it all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--binary", help=f"the server (default: {BINARY_VARIABLE}, else PATH)")
    parser.add_argument("--seconds", type=int, default=4, help="how long to step each game")
    parser.add_argument("--environments", type=int, default=64, help="environments of each game")
    parser.add_argument("--output", type=Path, default="quickstart.png", help="the picture")
    parser.add_argument("--log", type=Path, default="server.log", help="the server's log lines")
    parser.add_argument("--keep", action="store_true", help="leave the server running")
    parser.add_argument("--nodes", type=int, default=0, help="of a cluster; 0: one server, none")
    arguments = parser.parse_args()

    # An end from outside is an exception like any other, so that everything is undone.
    for end in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(end, lambda number, _: sys.exit(128 + number))

    log_path = arguments.log.resolve()
    log_path.unlink(missing_ok=True)  # A server that was kept goes on writing its own.
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
