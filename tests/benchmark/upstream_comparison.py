#!/usr/bin/env python3
"""libprocgen, Procgen 0.10.7 (upstream) and EnvPool's Procgen on one core, in one run.

Each contestant is a process that steps and observes 64 environments in easy mode through a Python
loop, on the same core; they take turns. A rate is environment steps per second of the process's CPU
time; other load hardly changes it. Memory and the first step are those of coinrun in a fresh
process of Python and NumPy: how much its resident memory grows, and its CPU time from loading the
package to the first step's observation. All are medians over the rounds.

The packages of the others come from the Python package index; what cannot be installed is left out.
Upstream's library is loaded through its C interface (clients/libenv), without upstream's Python
package, and gives libprocgen the folder of its images.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from libenv_environments import LibenvEnvironments
from released_packages import EnvpoolPackage, ProcgenPackage

GAMES = ("bigfish", "coinrun", "ninja", "maze")
_COUNT = 64
_START_GAME = "coinrun"  # It has the most images.
_COLUMNS = (*GAMES, "memory, MiB", "first step, s")
_TARGETS = {"own art": 8.0, "upstream's art": 5.0}


def _stepper(kind: str, package: str, images: str, game: str) -> Callable[[np.ndarray], np.ndarray]:
    if kind == "libenv":
        return LibenvEnvironments(Path(package), Path(images), game, _COUNT).step
    if kind == "envpool":
        import envpool

        environments = envpool.make(
            f"{game.capitalize()}Easy-v0", env_type="gymnasium", num_envs=_COUNT, num_threads=1,
            seed=1,
        )  # fmt: skip
        environments.reset()
        return lambda actions: environments.step(actions)[0]
    from library_pool import LibraryPool  # Its import is part of the first step.

    art = Path(images) if images else None
    return LibraryPool(Path(package), game, "easy", _COUNT, num_threads=0, art=art).step


def _resident_mib() -> float:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGESIZE") / 2**20


def _start(kind: str, package: str, images: str) -> None:
    """A fresh contestant: prints its memory in MiB and the seconds to the first step."""
    actions = np.random.default_rng(1).integers(0, 15, (100, _COUNT), np.int32)
    resident, begin = _resident_mib(), time.process_time()
    step = _stepper(kind, package, images, _START_GAME)
    step(actions[0])
    seconds = time.process_time() - begin
    for row in actions[1:]:
        step(row)
    print(_resident_mib() - resident, seconds)


def _work(kind: str, package: str, images: str) -> None:
    """A contestant: prints a digest of each game's first pictures, then answers `game seconds`."""
    actions = np.random.default_rng(1).integers(0, 15, (512, _COUNT), np.int32)
    steppers = {}
    digests = []
    for game in GAMES:
        steppers[game] = _stepper(kind, package, images, game)
        digest = hashlib.sha256()
        for t in range(100):
            digest.update(np.ascontiguousarray(steppers[game](actions[t])).data)
        digests.append(digest.hexdigest())
    print(*digests, flush=True)
    for line in sys.stdin:
        game, seconds = line.split()
        step, count = steppers[game], 0
        begin = time.process_time()
        while time.process_time() < begin + float(seconds):
            step(actions[count % len(actions)])
            count += 1
        print(count * _COUNT / (time.process_time() - begin), flush=True)


class _Contestant:
    def __init__(self, name: str, kind: str, package: Path, images: Path | None = None) -> None:
        self.name = name
        self._arguments = (kind, package, images or "")
        path = os.environ.get("PYTHONPATH", "")
        if kind == "envpool":
            path = f"{package}{os.pathsep}{path}"
        self._environment = {**os.environ, "PYTHONPATH": path}
        self._process = subprocess.Popen(
            [sys.executable, __file__, "--work", *self._arguments],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=self._environment,
        )  # fmt: skip
        self.digests = self._answer().split()[-len(GAMES) :]

    def _answer(self) -> str:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError(f"{self.name} ended with status {self._process.wait()}")
        return line

    def rate(self, game: str, seconds: float) -> float:
        assert self._process.stdin is not None
        self._process.stdin.write(f"{game} {seconds}\n")
        self._process.stdin.flush()
        return float(self._answer())

    def start(self) -> list[float]:
        """MiB and seconds to the first step of a fresh process."""
        run = subprocess.run(
            [sys.executable, __file__, "--start", *self._arguments],
            env=self._environment, stdout=subprocess.PIPE, text=True, check=True,
        )  # fmt: skip
        return [float(number) for number in run.stdout.split()[-2:]]

    def close(self) -> None:
        self._process.communicate()


def _contestants(library: Path, packages: Path) -> list[_Contestant]:
    procgen, envpool = ProcgenPackage(packages), EnvpoolPackage(packages)
    errors = {"Procgen 0.10.7": procgen.fetch(), "EnvPool": envpool.fetch()}
    found: list[tuple[str, str, Path, Path | None]] = [
        ("libprocgen, own art", "libprocgen", library, None)
    ]
    if not errors["Procgen 0.10.7"]:
        found.append(("libprocgen, upstream's art", "libprocgen", library, procgen.images))
        found.append(("Procgen 0.10.7", "libenv", procgen.library, procgen.images))
    if not errors["EnvPool"]:
        found.append(("EnvPool", "envpool", envpool.folder, None))
    started = []
    for contestant in found:
        try:
            started.append(_Contestant(*contestant))
        except RuntimeError as error:
            errors[contestant[0]] = str(error)
    for name, error in errors.items():
        if error:
            print(f"left out: {name}: {error}")
    return started


def _measure(contestants: list[_Contestant], rounds: int, seconds: float) -> dict[str, list[float]]:
    """Medians of each contestant, in the order of _COLUMNS."""
    turns: dict[str, list[list[float]]] = {each.name: [] for each in contestants}
    for _ in range(rounds):
        for each in contestants:
            turns[each.name].append(each.start())
        for game in GAMES:
            for each in contestants:
                turns[each.name][-1].append(each.rate(game, seconds))
    medians = {name: list(map(statistics.median, zip(*rows))) for name, rows in turns.items()}
    return {name: row[2:] + row[:2] for name, row in medians.items()}


def _report(rows: dict[str, list[float]]) -> None:
    print(f"| | {' | '.join(_COLUMNS)} |")
    print(f"| --- |{' ---: |' * len(_COLUMNS)}")
    for name, row in rows.items():
        cells = [f"{value:,.0f}" for value in row[:-1]] + [f"{row[-1]:.2f}"]
        print(f"| {name} | {' | '.join(cells)} |")
    others = [row for name, row in rows.items() if "libprocgen" not in name]
    if not others:
        return
    best = [(max if column in GAMES else min)(values)
            for column, values in zip(_COLUMNS, zip(*others))]  # fmt: skip
    for art in _TARGETS:
        row = rows.get(f"libprocgen, {art}", [])
        if row:
            cells = [f"{value / other:.2g}" for value, other in zip(row, best)]
            print(f"| ratio, {art} | {' | '.join(cells)} |")
    print("A ratio is to the best of the others. Targets of the rates: "
          + ", ".join(f"{target:g} with {art}" for art, target in _TARGETS.items()))  # fmt: skip


def main() -> None:
    """Prints a table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("library", nargs="?", type=Path, metavar="LIBPROCGEN")
    parser.add_argument("--packages", type=Path, help="folder that keeps what is fetched")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--seconds", type=float, default=0.5, help="CPU time of one turn")
    for role in ("--work", "--start"):
        parser.add_argument(role, nargs=3, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    for role, given in ((_work, arguments.work), (_start, arguments.start)):
        if given:
            role(*given)
            return
    if arguments.library is None:
        parser.error("LIBPROCGEN is missing: a file such as build/library/lib/libprocgen.so.1")
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # of this process and its children
    with tempfile.TemporaryDirectory() as temporary:
        packages = (arguments.packages or Path(temporary)).resolve()
        packages.mkdir(parents=True, exist_ok=True)
        contestants = _contestants(arguments.library.resolve(), packages)
        _report(_measure(contestants, arguments.rounds, arguments.seconds))
        digests = {each.name: each.digests for each in contestants}
        compared = [digests.get(name) for name in ("Procgen 0.10.7", "libprocgen, upstream's art")]
        if all(compared):
            equal = compared[0] == compared[1]
            print("First pictures of libprocgen with upstream's art equal upstream's:",
                  "yes" if equal else "NO")  # fmt: skip
        for contestant in contestants:
            contestant.close()


if __name__ == "__main__":
    main()
