#!/usr/bin/env python3
"""Compares a learner's rate with and without open pages that show its environments.

Usage: viewers_benchmark.py [--viewers N] [--policy-ms MS] [--rounds N]

The learner waits for each response and then MS milliseconds, as for a policy on a GPU. The sockets
of the pages are in a process of low priority. PROCGEN_SERVER_BINARY names the server's program.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import itertools
import os
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from statistics import median

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "service/web"))
from bridge_page import POOLS, Api, BridgePage, Call, CallError, open_bridge
from page import serve

from procgen_client import Client, Pool

_POOL = "pools/watched"
_WATCH = {"environments": [*range(16)], "frames_per_second_max": 15, "size_px": 64}
_SECONDS = 3.0  # Of a measurement.


class _Learner(threading.Thread):
    """Steps a pool until `stop`."""

    def __init__(self, pool: Pool, policy_seconds: float) -> None:
        super().__init__()
        self._pool, self._policy_seconds = pool, policy_seconds
        self._step_count = 0
        self._is_stopping = threading.Event()

    def run(self) -> None:
        random = np.random.default_rng(0)
        actions = [random.integers(0, 15, self._pool.env_count) for _ in range(100)]
        for its_actions in itertools.cycle(actions):
            self._pool.step(its_actions)
            self._step_count += 1
            if self._is_stopping.wait(self._policy_seconds):
                return

    def stop(self) -> None:
        self._is_stopping.set()
        self.join()

    def rate(self) -> float:
        """Returns the steps per second, measured from now on."""
        begin, count = time.perf_counter(), self._step_count
        time.sleep(_SECONDS)
        return (self._step_count - count) / (time.perf_counter() - begin)


async def _view(url: str, viewer_count: int) -> None:
    """Opens pages. Each line of standard input starts or stops their watches.

    Answers with the number of frame sets that a page has received.
    """
    frame_sets = 0

    async def read(watch: Call) -> None:
        nonlocal frame_sets
        with contextlib.suppress(CallError):
            while await watch.read_bytes():
                frame_sets += 1

    async def start(page: BridgePage) -> Call:
        encoding = {"encoding": "ENCODING_DELTA_ZSTD"}
        request = page.api.message("WatchPoolRequest", pool=_POOL, **_WATCH, **encoding)
        return await page.start(f"{POOLS}WatchPool", request)

    api = Api(url)
    async with contextlib.AsyncExitStack() as stack:
        pages = [
            await stack.enter_async_context(open_bridge(url, api=api)) for _ in range(viewer_count)
        ]
        for page in pages:
            await page.pool_names()
        watches: list[Call] = []
        readers: list[asyncio.Task[None]] = []
        while await asyncio.to_thread(sys.stdin.readline):
            if watches:
                for watch in watches:
                    await watch.cancel()
                await asyncio.gather(*readers)
                watches = []
            else:
                watches = [await start(page) for page in pages]
                readers = [asyncio.create_task(read(watch)) for watch in watches]
            print(frame_sets / viewer_count, flush=True)


def _compare(url: str, learner: _Learner, viewer_count: int, rounds: int) -> None:
    viewers = subprocess.Popen(
        [sys.executable, __file__, "--viewers", str(viewer_count), "--view", url],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )

    def toggle() -> float:
        assert viewers.stdin is not None and viewers.stdout is not None
        viewers.stdin.write("\n")
        viewers.stdin.flush()
        return float(viewers.stdout.readline())

    ratios, frame_rates = [], []
    for _ in range(rounds):
        frame_sets, begin = toggle(), time.perf_counter()
        watched = learner.rate()
        frame_rates.append((toggle() - frame_sets) / (time.perf_counter() - begin))
        ratios.append(watched / learner.rate())
    viewers.communicate()
    print(
        f"rate with {viewer_count} viewers / rate without: median {median(ratios):.3f}, "
        f"{min(ratios):.3f} to {max(ratios):.3f}; {median(frame_rates):.1f} frame sets of "
        f"{len(_WATCH['environments'])} environments per viewer and second"
    )


def main() -> None:
    """Runs the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--viewers", type=int, default=20, help="default: %(default)s")
    parser.add_argument("--policy-ms", type=float, default=5, help="default: %(default)s")
    parser.add_argument("--rounds", type=int, default=20, help="default: %(default)s")
    parser.add_argument("--view", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.view:
        os.nice(19)
        asyncio.run(_view(arguments.view, arguments.viewers))
        return
    with (
        tempfile.TemporaryDirectory() as folder,
        serve(Path(folder)) as server,
        Client(server.process.address) as client,
        client.create_pool(
            "coinrun", 64, pool_id=_POOL.removeprefix("pools/"), distribution_mode="easy"
        ) as pool,
    ):
        learner = _Learner(pool, arguments.policy_ms / 1e3)
        learner.start()
        try:
            _compare(server.url, learner, arguments.viewers, arguments.rounds)
        finally:
            learner.stop()


if __name__ == "__main__":
    main()
