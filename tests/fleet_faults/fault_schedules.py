#!/usr/bin/env python3
"""Runs random schedules of faults on hosts, each drawn from a seed.

A schedule passes if the learner's trace equals that of one server, bit for bit. A failed schedule
is printed with its seed, and its logs are kept; --seed N --count 1 runs it again. Exit status: 0
all passed, 1 some failed, 77 network namespaces are not permitted.
"""

from __future__ import annotations

import argparse
import shutil
import signal
import sys
import tempfile
import time
from pathlib import Path

from faults import THEMES, FaultDriver, draw
from learner_process import LearnerError
from learner_script import Script
from learner_trace import difference
from network import NotPermittedError
from testbed import TIMEOUT_S, Testbed, single_server_trace

_SKIPPED = 77


def play(
    seed: int, request_count: int, theme: str | None, folder: Path
) -> tuple[str | None, float]:
    """Runs the schedule of a seed; returns the error, if any, and the longest pause in seconds."""
    script = Script(
        seed=seed, request_count=request_count, sent_ahead=1 + seed % 3, chunk_count=1 + seed % 4
    )
    expected = single_server_trace(script, folder)
    schedule = draw(seed, request_count, theme)
    try:
        # Schedules alternate between multicast and peers.
        with Testbed(
            folder, multicast=seed % 2 == 0, disk=theme == "disk", clocks=theme == "clock"
        ) as testbed:
            announced = tuple(fault.request for fault in schedule)
            learner = testbed.learner(script, announce=announced)
            FaultDriver(testbed).run(schedule, learner)
            actual = learner.trace(TIMEOUT_S)
    except (LearnerError, TimeoutError) as error:
        return str(error), 0.0
    return difference(expected, actual), float(actual.durations.max())


def main() -> int:
    """The program."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1, help="of the first schedule (default: 1)")
    parser.add_argument("--count", type=int, default=100, help="of schedules (default: 100)")
    parser.add_argument("--requests", type=int, default=1500, help="a schedule (default: 1500)")
    parser.add_argument("--theme", choices=THEMES, help="a kind of fault besides the others")
    arguments = parser.parse_args()
    failed = []
    for seed in range(arguments.seed, arguments.seed + arguments.count):
        print(f"seed {seed}", flush=True)
        for fault in draw(seed, arguments.requests, arguments.theme):
            print(f"  {fault}", flush=True)
        folder = Path(tempfile.mkdtemp(prefix=f"procgen-schedule-{seed}-"))
        begin = time.monotonic()
        try:
            found, pause = play(seed, arguments.requests, arguments.theme, folder)
        except NotPermittedError as error:
            print(f"skipped: {error}")
            shutil.rmtree(folder)
            return _SKIPPED
        if found is None:
            took = time.monotonic() - begin
            print(f"  passed in {took:.1f} s; longest pause {pause:.2f} s", flush=True)
            shutil.rmtree(folder)
        else:
            print(f"  FAILED: {found}\n  logs: {folder}", flush=True)
            failed.append(seed)
    print(f"{arguments.count - len(failed)} passed, {len(failed)} failed: {failed or 'none'}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
