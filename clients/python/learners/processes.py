"""Programs side by side, each with a part of the cores: the runs of an experiment."""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from typing import Any, NamedTuple

import torch

_SIGNALS = (signal.SIGTERM, signal.SIGINT)
_MPS = "nvidia-cuda-mps-control"
_MPS_PIPES, _MPS_LOGS = "CUDA_MPS_PIPE_DIRECTORY", "CUDA_MPS_LOG_DIRECTORY"


def add_process_options(parser: argparse.ArgumentParser) -> None:
    """Adds the options `jobs` and `time_limit`."""
    parser.add_argument("--jobs", type=_positive, default=1, help="runs at a time; default: 1")
    parser.add_argument(
        "--time-limit", type=float, default=float("inf"), help="of all runs, in seconds; then save"
    )


def _positive(text: str) -> int:
    if int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text} is less than 1")
    return int(text)


class Program(NamedTuple):
    """A program to run."""

    label: str
    words: list[str]  # The command line.
    ended: Callable[[], None]  # Is called after its success, one call at a time.


class Processes:
    """Runs programs in their order, several at a time.

    A signal is passed on to the programs that run, and no other starts. After a failure they go on.
    """

    def __init__(self, count: int, time_limit: float = float("inf")) -> None:
        """Takes the number of programs at a time, and the time for all programs in seconds.

        With a limit, each gets the rest as its option `--time-limit`; none starts after it.
        """
        self._count = count
        self._end = time.monotonic() + time_limit
        self._lock = threading.RLock()  # A handler of a signal can interrupt another.
        self._running: set[subprocess.Popen[str]] = set()
        self._signal = 0
        self._status = 0  # Of the last program that failed.

    def run(self, programs: Iterable[Program]) -> int:
        """Returns the exit status after the last program: 0, of a failure, or 128 plus a signal.

        With several at a time, labels precede their output.
        """
        handlers = {number: signal.signal(number, self._on_signal) for number in _SIGNALS}
        waiting = iter(programs)
        try:
            with _multi_process_service(self._count) as environment:
                with ThreadPoolExecutor(self._count) as pool:
                    parts = _parts_of_cores(self._count)
                    run = partial(self._run_each, waiting, environment)
                    list(pool.map(run, parts))  # Raises what a thread raises.
        finally:
            for number, handler in handlers.items():
                signal.signal(number, handler)
        return 128 + self._signal if self._signal else self._status

    def _run_each(
        self, waiting: Iterator[Program], environment: Mapping[str, str], cores: set[int]
    ) -> None:
        os.sched_setaffinity(0, cores)  # Of this thread; its processes inherit it.
        pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
        while True:
            with self._lock:
                program = None if self._signal else next(waiting, None)
                left = self._end - time.monotonic()
                if program is None or left <= 0:
                    return
                print(program.label, flush=True)
                limit = ["--time-limit", str(left)] if left < float("inf") else []
                process = subprocess.Popen(
                    [*program.words, *limit],
                    env=environment,
                    text=True,
                    **(pipes if self._count > 1 else {}),
                )
                self._running.add(process)
            with process:
                for line in process.stdout or ():
                    print(f"{program.label}: {line}", end="", flush=True)
            with self._lock:
                self._running.remove(process)
                code = process.returncode
                if code == 0:
                    program.ended()
                else:
                    self._status = code if code > 0 else 128 - code
                    print(f"{program.label} ended with status {self._status}", flush=True)

    def _on_signal(self, number: int, frame: Any) -> None:  # noqa: ANN401
        with self._lock:
            self._signal = number
            for process in self._running:
                process.send_signal(number)


def _parts_of_cores(count: int) -> list[set[int]]:
    """Returns the cores of each of `count` programs; some share one if there are fewer cores."""
    cores = sorted(os.sched_getaffinity(0))
    if len(cores) < count:
        return [{cores[i % len(cores)]} for i in range(count)]
    bounds = [i * len(cores) // count for i in range(count + 1)]
    return [set(cores[bounds[i] : bounds[i + 1]]) for i in range(count)]


@contextmanager
def _multi_process_service(count: int) -> Iterator[Mapping[str, str]]:
    """Yields the environment of `count` programs. They use a GPU at the same time, not in turns.

    For several programs starts NVIDIA's MPS, if it is installed, and stops it at the end; one that
    the environment names is used.
    """
    program = shutil.which(_MPS)
    if count == 1 or program is None or _MPS_PIPES in os.environ:
        yield os.environ
        return
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {_MPS_PIPES: folder, _MPS_LOGS: folder}
        started = subprocess.run([program, "-d"], env=environment, check=False)
        try:
            if started.returncode == 0 and _can_compute(environment):
                yield environment
            else:
                print(f"{_MPS} does not work here: programs use a GPU in turns", flush=True)
                yield os.environ
        finally:
            subprocess.run([program], input="quit\n", text=True, env=environment, check=False)


def _can_compute(environment: Mapping[str, str]) -> bool:
    """Returns whether a program with this environment computes on the device of this process."""
    device = "cuda" if torch.cuda.is_available() else "cpu"
    check = [sys.executable, "-c", f"import torch; torch.zeros(1, device='{device}')"]
    try:
        return subprocess.run(check, env=environment, check=False, timeout=120).returncode == 0
    except subprocess.TimeoutExpired:
        return False
