#!/usr/bin/env python3
"""Runs random schedules of faults on hosts, each drawn from a seed.

A schedule passes if the learner's trace equals that of one undisturbed server, bit for bit, and no
server keeps a pool. Two of three have three servers, the third has one; the pool's options vary,
too. A failed schedule is printed with its seed, and its logs are kept; --seed N --count 1 runs it
again. Exit status: 0 all passed, 1 some failed, 77 network namespaces are not permitted.
"""

from __future__ import annotations

import argparse
import shutil
import signal
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from faults import THEMES, Fault, draw, play
from learner_process import LearnerError
from learner_script import Script
from learner_trace import difference
from network import NotPermittedError
from testbed import SERVERS, Testbed, undisturbed_trace

_SKIPPED = 77
_AUTORESET_MODES = ("same_step", "next_step", "disabled")


def hosts_of(seed: int) -> tuple[str, ...]:
    """Returns the hosts of the servers."""
    return SERVERS[:1] if seed % 3 == 0 else SERVERS


def script_of(seed: int, request_count: int) -> Script:
    """Returns the learner's script, with all autoreset modes, frame stacks and encodings."""
    options: dict[str, Any] = {
        "autoreset_mode": _AUTORESET_MODES[seed // 3 % 3],
        "frame_stack": 3 if seed % 4 == 1 else 1,
        "encoding": "delta_zstd" if seed % 5 == 2 else "raw",
    }
    ahead = 1 if options["autoreset_mode"] == "disabled" else 1 + seed % 3
    return Script(seed=seed, request_count=request_count, sent_ahead=ahead, options=options)


def run(
    seed: int, script: Script, schedule: list[Fault], folder: Path
) -> tuple[str | None, float]:
    """Runs a schedule; returns the error, if any, and the longest pause in seconds."""
    expected = undisturbed_trace(script, folder)
    clocks = any(fault.kind == "clock" for fault in schedule)
    try:
        with Testbed(folder, hosts_of(seed), clocks=clocks) as testbed:
            actual = play(testbed, script, schedule)
    except (AssertionError, LearnerError, TimeoutError) as error:
        return f"{type(error).__name__}: {error}", 0.0
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
        script = script_of(seed, arguments.requests)
        schedule = draw(seed, arguments.requests, hosts_of(seed), arguments.theme)
        print(f"seed {seed}: {len(hosts_of(seed))} servers, {script.options}", flush=True)
        for fault in schedule:
            print(f"  {fault}", flush=True)
        folder = Path(tempfile.mkdtemp(prefix=f"procgen-schedule-{seed}-"))
        begin = time.monotonic()
        try:
            found, pause = run(seed, script, schedule, folder)
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
