#!/usr/bin/env python3
"""Recording and expanding data sets, compared with the engine's rate, on one core.

The engine is `Pool.step` of 64 environments with all observations. `recording` is relative to it.
Expansions write to memory (/dev/shm), so that no disk bounds them; they are relative to the rate of
drawing and writing, that of the engine and then `write` of as many bytes. These rates are of CPU
time, which other load changes little; the contestants take turns, and the median counts.

`loader` and `read` give the same random segments, in wall time: TrajectoryDataset draws them, and
`read` reads them from an expansion in --folder, without what the system keeps in memory.
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from procgen_client import Pool
from procgen_client.dataset import TrajectoryDataset, parts_of, record
from procgen_client.dataset.expansion import Expansion, Replay, expand, prepare

_STEPS = 64 * 512
_LENGTH = 16


def _rate(work: Callable[[], int], clock: Callable[[], float]) -> float:
    """Returns steps per second of work that returns its number of steps."""
    begin = clock()
    count = work()
    return count / (clock() - begin)


class _Contest:
    """A game's contestants."""

    def __init__(self, game: str, memory: Path, disk: Path) -> None:
        self._options = {"distribution_mode": "easy"}
        (self._part,) = parts_of(disk, game, step_count=_STEPS, options=self._options)
        record(self._part)
        self._pool = Pool(game, 64, rand_seed=0, num_threads=0, **self._options)
        self._memory, self._disk = memory, disk
        self._dataset = TrajectoryDataset(self._part.path, _LENGTH, num_threads=0)
        expansion = Expansion("npz", disk / "frames", _LENGTH)
        prepare([self._part.path], expansion)
        expand(Replay(self._part.path, expansion))
        self._frames = sorted((disk / "frames").glob("*.npz"))

    def engine(self) -> int:
        actions = np.random.default_rng(0).integers(0, 15, (256, 64), np.int32)
        for row in actions:
            self._pool.step(row)
        return actions.size

    def recording(self) -> int:
        self._part.path.unlink()
        record(self._part)
        return _STEPS

    def _expansion(self, name: str) -> int:
        expansion = Expansion(name, self._memory)
        prepare([self._part.path], expansion)
        expand(Replay(self._part.path, expansion))
        for path in self._memory.iterdir():
            path.unlink()
        return _STEPS

    def writing(self) -> int:
        frames = np.zeros((_LENGTH * 64, 12288), np.uint8)
        for i in range(_STEPS // len(frames)):
            (self._memory / str(i)).write_bytes(frames.data)
        for path in self._memory.iterdir():
            path.unlink()
        return _STEPS

    def npz(self) -> int:
        return self._expansion("npz")

    def webdataset(self) -> int:
        return self._expansion("webdataset")

    def loader(self) -> int:
        order = np.random.default_rng(0).permutation(len(self._dataset))[:512]
        for rows in np.split(order, 8):
            self._dataset[rows]
        return len(order) * _LENGTH

    def read(self) -> int:
        """Reads as many segments from a file for each, without those that the system keeps."""
        header = 512  # About that of an archive; its content does not matter here.
        size = 12288 * _LENGTH
        order = np.random.default_rng(0).permutation(len(self._dataset))[:512]
        for path in self._frames:
            with open(path, "rb") as file:
                os.fsync(file.fileno())
                os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)
        for index in order.tolist():
            env, segment = divmod(index, len(self._frames))
            with open(self._frames[segment], "rb") as file:
                np.frombuffer(os.pread(file.fileno(), size, header + env * size), np.uint8)
        return len(order) * _LENGTH


_CPU = ("engine", "recording", "writing", "npz", "webdataset")
_WALL = ("loader", "read")


def main() -> None:
    """Prints a table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--games", nargs="+", default=["bigfish", "coinrun", "ninja"])
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--folder", type=Path, default=Path("."), help="on the disk to be read")
    arguments = parser.parse_args()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    print("| game | engine | recording | engine and write | npz | webdataset | loader | read |")
    print("| --- |" + " ---: |" * 7)
    for game in arguments.games:
        memory = Path(tempfile.mkdtemp(dir="/dev/shm"))
        disk = Path(tempfile.mkdtemp(dir=arguments.folder))
        try:
            contest = _Contest(game, memory, disk)
            rates: dict[str, list[float]] = {name: [] for name in (*_CPU, *_WALL)}
            for _ in range(arguments.turns):
                for name in rates:
                    clock = time.process_time if name in _CPU else time.perf_counter
                    rates[name].append(_rate(getattr(contest, name), clock))
            median = {name: statistics.median(found) for name, found in rates.items()}
            bound = 1 / (1 / median["engine"] + 1 / median["writing"])
            cells = [f"{median['engine']:,.0f}", f"{median['recording'] / median['engine']:.2f}"]
            cells.append(f"{bound:,.0f}")
            cells += [f"{median[each] / bound:.2f}" for each in ("npz", "webdataset")]
            cells += [f"{median[each]:,.0f}" for each in _WALL]
            print(f"| {game} | {' | '.join(cells)} |", flush=True)
        finally:
            shutil.rmtree(memory)
            shutil.rmtree(disk)


if __name__ == "__main__":
    main()
