"""Programs side by side, each with a part of the cores: the runs of an experiment."""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple

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

    A signal is passed on to the programs that run. When one fails, the others get SIGTERM.
    """

    def __init__(self, count: int, time_limit: float = float("inf")) -> None:
        """Takes the number of programs at a time, and the time for all programs in seconds.

        With a limit, each gets the rest as its option `--time-limit`; none starts after it.
        """
        self._count = count
        self._end = time.monotonic() + time_limit
        self._lock = threading.RLock()  # A handler of a signal can interrupt another.
        self._running: set[subprocess.Popen[str]] = set()
        self._status = 0  # Of the first program that failed, or 128 plus a signal.

    def run(self, programs: Iterable[Program]) -> None:
        """Returns after the last program. With several at a time, labels precede their output.

        Raises:
            SystemExit: A signal arrived, or a program failed.
        """
        handlers = {
            number: signal.signal(number, lambda n, _: self._stop(n, 128 + n))
            for number in _SIGNALS
        }
        waiting = iter(programs)
        try:
            with _multi_process_service(self._count) as environment:
                threads = [
                    threading.Thread(target=self._run_each, args=(waiting, cores, environment))
                    for cores in _parts_of_cores(self._count)
                ]
                for thread in threads:
                    thread.start()
                for thread in threads:
                    thread.join()
        finally:
            for number, handler in handlers.items():
                signal.signal(number, handler)
        if self._status:
            raise SystemExit(self._status)

    def _run_each(
        self, waiting: Iterator[Program], cores: set[int], environment: Mapping[str, str]
    ) -> None:
        os.sched_setaffinity(0, cores)  # Of this thread; its processes inherit it.
        pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
        while True:
            with self._lock:
                program = None if self._status else next(waiting, None)
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
                if process.returncode == 0:
                    program.ended()
                else:
                    code = process.returncode
                    self._stop(signal.SIGTERM, code if code > 0 else 128 - code)

    def _stop(self, number: int, status: int) -> None:
        with self._lock:
            self._status = self._status or status
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
        if started.returncode:
            print(f"{_MPS} -d failed: programs use a GPU in turns", flush=True)
            yield os.environ
            return
        try:
            yield environment
        finally:
            subprocess.run([program], input="quit\n", text=True, env=environment, check=False)
