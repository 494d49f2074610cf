#!/usr/bin/env python3
"""libprocgen, Procgen 0.10.7 (upstream) and EnvPool's Procgen on one core, in one run.

Each contestant is a process that steps and observes 64 environments in easy mode through a Python
loop, on the same core; they take turns. A rate is environment steps per second of the process's CPU
time, median over the rounds; other load hardly changes it. The packages of the others come from the
Python package index; what cannot be installed is left out. Upstream's library is loaded through its
C interface (clients/libenv), and gives libprocgen the folder of its images.
"""

from __future__ import annotations

import argparse
import ctypes
import hashlib
import os
import statistics
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from library_pool import LibraryPool

GAMES = ("bigfish", "coinrun", "ninja", "maze")
_COUNT = 64
_UINT8, _INT32 = 1, 2  # libenv.h
_TARGETS = {"own art": 8.0, "upstream's art": 5.0}


class _Option(ctypes.Structure):
    """LibenvOption."""

    _fields_ = (
        ("name", ctypes.c_char * 128),
        ("value_type", ctypes.c_int),
        ("count", ctypes.c_int),
        ("data", ctypes.c_void_p),
    )


class _Options(ctypes.Structure):
    """LibenvOptions."""

    _fields_ = (("items", ctypes.POINTER(_Option)), ("count", ctypes.c_int))


class _Buffers(ctypes.Structure):
    """LibenvBuffers."""

    _fields_ = tuple(
        (name, ctypes.c_void_p)
        for name in ("observations", "rewards", "firsts", "infos", "actions")
    )


class LibenvEnvironments:
    """Environments of a library with the interface of clients/libenv."""

    def __init__(self, library: Path, images: Path, game: str) -> None:
        """Creates them, with the defaults of upstream's Python package."""
        self._library = ctypes.CDLL(os.fspath(library))
        self._library.libenv_make.restype = ctypes.c_void_p
        self._library.libenv_make.argtypes = (ctypes.c_int, _Options)
        for name in ("libenv_set_buffers", "libenv_act", "libenv_observe"):
            function = getattr(self._library, name)
            function.restype = None
            function.argtypes = (ctypes.c_void_p,) * (2 if name == "libenv_set_buffers" else 1)
        strings = {"env_name": game, "resource_root": f"{images}/"}
        numbers = {"num_levels": 0, "start_level": 0, "num_actions": 15, "rand_seed": 1,
                   "num_threads": 0, "distribution_mode": 0, "debug_mode": 0}  # fmt: skip
        flags = {"center_agent": 1, "use_backgrounds": 1, "use_sequential_levels": 0,
                 "use_generated_assets": 0, "use_monochrome_assets": 0, "restrict_themes": 0,
                 "paint_vel_info": 0, "render_human": 0}  # fmt: skip
        given = [(name, _UINT8, np.frombuffer(text.encode(), np.uint8))
                 for name, text in strings.items()]  # fmt: skip
        given += [(name, _INT32, np.array([number], np.int32)) for name, number in numbers.items()]
        given += [(name, _UINT8, np.array([flag], np.uint8)) for name, flag in flags.items()]
        items = (_Option * len(given))(
            *(_Option(name.encode(), kind, len(data), data.ctypes.data)
              for name, kind, data in given)
        )  # fmt: skip
        self._handle = self._library.libenv_make(_COUNT, _Options(items, len(given)))
        if not self._handle:
            raise RuntimeError("libenv_make failed")
        self._observations = np.zeros((_COUNT, 64, 64, 3), np.uint8)
        self._actions = np.zeros(_COUNT, np.int32)
        self._rewards = np.zeros(_COUNT, np.float32)
        self._firsts = np.zeros(_COUNT, np.uint8)
        self._infos = np.zeros((4, _COUNT), np.int64)  # of 4 bytes or less each
        self._pointers = [
            (ctypes.c_void_p * len(rows))(*(row.ctypes.data for row in rows))
            for rows in (
                list(self._observations),
                [self._infos[i, j : j + 1] for i in range(4) for j in range(_COUNT)],
                [self._actions[j : j + 1] for j in range(_COUNT)],
            )
        ]
        observations, infos, actions = map(ctypes.addressof, self._pointers)
        buffers = _Buffers(observations, self._rewards.ctypes.data, self._firsts.ctypes.data,
                           infos, actions)  # fmt: skip
        self._library.libenv_set_buffers(self._handle, ctypes.addressof(buffers))
        self._library.libenv_observe(self._handle)

    def step(self, actions: np.ndarray) -> np.ndarray:
        """Steps all environments. Returns memory that the next call overwrites."""
        self._actions[:] = actions
        self._library.libenv_act(self._handle)
        self._library.libenv_observe(self._handle)
        return self._observations


def _stepper(kind: str, package: str, images: str, game: str) -> Callable[[np.ndarray], np.ndarray]:
    if kind == "libenv":
        return LibenvEnvironments(Path(package), Path(images), game).step
    if kind == "envpool":
        import envpool

        environments = envpool.make(
            f"{game.capitalize()}Easy-v0", env_type="gymnasium", num_envs=_COUNT, num_threads=1,
            seed=1,
        )  # fmt: skip
        environments.reset()
        return lambda actions: environments.step(actions)[0]
    art = Path(images) if images else None
    return LibraryPool(Path(package), game, "easy", _COUNT, num_threads=0, art=art).step


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
        path = os.environ.get("PYTHONPATH", "")
        if kind == "envpool":
            path = f"{package}{os.pathsep}{path}"
        self._process = subprocess.Popen(
            [sys.executable, __file__, "--work", kind, package, images or ""],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            env={**os.environ, "PYTHONPATH": path},
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

    def close(self) -> None:
        self._process.communicate()


def _pip(*arguments: str | Path) -> str:
    """Runs pip. Returns its error, empty if there is none."""
    run = subprocess.run([sys.executable, "-m", "pip", *arguments, "--quiet"],
                         capture_output=True, text=True, check=False)  # fmt: skip
    return run.stderr.strip().splitlines()[-1] if run.returncode else ""


def _install(packages: Path) -> dict[str, str]:
    """Fetches the packages that are not there. Returns why, for those that cannot be had."""
    errors = {}
    if not (packages / "procgen").exists():
        errors["Procgen 0.10.7"] = _pip(
            "download", "--no-deps", "--only-binary=:all:", "--python-version=3.10",
            "--platform=manylinux2014_x86_64", "--dest", packages, "procgen==0.10.7",
        )  # fmt: skip
        for wheel in packages.glob("procgen-*.whl"):
            zipfile.ZipFile(wheel).extractall(packages)
    if not (packages / "envpool/envpool").exists():
        errors["EnvPool"] = _pip("install", "--target", packages / "envpool", "envpool")
    return {name: error for name, error in errors.items() if error}


def _contestants(library: Path, packages: Path) -> list[_Contestant]:
    upstream = packages / "procgen/data/prebuilt/libenv.so"
    images = packages / "procgen/data/assets"
    found: list[tuple[str, str, Path, Path | None]] = [
        ("libprocgen, own art", "libprocgen", library, None)
    ]
    if upstream.exists():
        found.append(("libprocgen, upstream's art", "libprocgen", library, images))
        found.append(("Procgen 0.10.7", "libenv", upstream, images))
    if (packages / "envpool/envpool").exists():
        found.append(("EnvPool", "envpool", packages / "envpool", None))
    started = []
    for contestant in found:
        try:
            started.append(_Contestant(*contestant))
        except RuntimeError as error:
            print(f"left out: {error}")
    return started


def _report(contestants: list[_Contestant], rates: dict[str, dict[str, float]]) -> None:
    print(f"| game | {' | '.join(each.name for each in contestants)} | ratio, "
          f"{' | ratio, '.join(_TARGETS)} |")  # fmt: skip
    print(f"| --- |{' ---: |' * (len(contestants) + len(_TARGETS))}")
    for game, row in rates.items():
        others = [row[each.name] for each in contestants if "libprocgen" not in each.name]
        ratios = [
            f"{row[name] / max(others):.1f}" if others and name in row else "-"
            for name in (f"libprocgen, {art}" for art in _TARGETS)
        ]
        cells = [f"{row[each.name]:,.0f}" for each in contestants] + ratios
        print(f"| {game} | {' | '.join(cells)} |")
    print("A ratio is to the faster of the others. Targets: "
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
    parser.add_argument("--work", nargs=3, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.work:
        _work(*arguments.work)
        return
    if arguments.library is None:
        parser.error("LIBPROCGEN is missing: a file such as build/library/lib/libprocgen.so.1")
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # of this process and its children
    with tempfile.TemporaryDirectory() as temporary:
        packages = (arguments.packages or Path(temporary)).resolve()
        packages.mkdir(parents=True, exist_ok=True)
        for name, error in _install(packages).items():
            print(f"left out: {name}: {error}")
        contestants = _contestants(arguments.library.resolve(), packages)
        rates: dict[str, dict[str, float]] = {}
        for game in GAMES:
            turns = [
                {each.name: each.rate(game, arguments.seconds) for each in contestants}
                for _ in range(arguments.rounds)
            ]
            rates[game] = {
                each.name: statistics.median(turn[each.name] for turn in turns)
                for each in contestants
            }
        _report(contestants, rates)
        digests = {each.name: each.digests for each in contestants}
        if "Procgen 0.10.7" in digests:
            equal = digests["Procgen 0.10.7"] == digests["libprocgen, upstream's art"]
            print("First pictures of libprocgen with upstream's art equal upstream's:",
                  "yes" if equal else "NO")  # fmt: skip
        for contestant in contestants:
            contestant.close()


if __name__ == "__main__":
    main()
