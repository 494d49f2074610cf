"""Runs jobs in processes, one for each core."""

from __future__ import annotations

import concurrent.futures
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from procgen_client.errors import CancelledError, ProcgenError, StatusCode

_POLL_S = 0.2
# Of a worker process: the number of steps of all workers, and whether they have to stop.
_steps: Any = None
_stops: Any = None

Report = Callable[[int], None]


def run(
    function: Callable[[Any, Report], None],
    jobs: Sequence[Any],
    workers: int,
    progress: Callable[[int], None],
) -> None:
    """Calls ``function(job, report)`` for each job; `report` takes numbers of steps.

    An exception, of a job or of a signal handler such as Ctrl-C, stops the other jobs at their next
    report. If this process is killed, so are its workers.

    Args:
        function: A function of a module.
        jobs: Arguments that can be pickled.
        workers: Number of processes. 1: this one.
        progress: Called with the number of all reported steps, at most every 0.2 s.

    Raises:
        ProcgenError: Of a job; or a worker process died.
        OSError: Of a job.
    """
    if min(workers, len(jobs)) <= 1:
        _run_here(function, jobs, progress)
        return
    context = multiprocessing.get_context("spawn")
    steps: Any = context.Value("q", 0)
    stops: Any = context.Value("b", 0)
    executor = concurrent.futures.ProcessPoolExecutor(
        min(workers, len(jobs)), context, _initialize, (steps, stops)
    )
    try:
        # Ctrl-C goes to all processes of a terminal; the workers, which begin here, inherit this.
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            waiting = {executor.submit(_run_there, function, job) for job in jobs}
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        while waiting:
            done, waiting = concurrent.futures.wait(
                waiting, _POLL_S, concurrent.futures.FIRST_COMPLETED
            )
            for future in done:
                future.result()
            progress(steps.value)
    except BrokenProcessPool:
        raise ProcgenError(
            "a worker process was killed, perhaps for its memory: repeat the command, with fewer "
            "workers",
            StatusCode.ABORTED,
        ) from None
    finally:
        stops.value = 1
        executor.shutdown(cancel_futures=True)


def _run_here(
    function: Callable[[Any, Report], None],
    jobs: Sequence[Any],
    progress: Callable[[int], None],
) -> None:
    count, last = 0, 0.0

    def report(added: int) -> None:
        nonlocal count, last
        count += added
        if time.perf_counter() >= last + _POLL_S:
            last = time.perf_counter()
            progress(count)

    for job in jobs:
        function(job, report)
    progress(count)


def _initialize(steps: Any, stops: Any) -> None:  # noqa: ANN401
    global _steps, _stops
    _steps, _stops = steps, stops
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _run_there(function: Callable[[Any, Report], None], job: Any) -> None:  # noqa: ANN401
    def report(added: int) -> None:
        if _stops.value:
            raise CancelledError("another job failed")
        with _steps.get_lock():
            _steps.value += added

    report(0)
    function(job, report)
