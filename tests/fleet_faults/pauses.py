#!/usr/bin/env python3
"""Measures how long a learner of 256 environments on three nodes waits when a node fails.

For each kind of fault, nodes fail in turn and recover some requests later. Prints a table of the
longest response time during each fault: p50 and maximum over the faults.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
from pathlib import Path

from faults import KINDS, Fault, FaultDriver
from fleet import FLEET
from learner_script import Script
from learner_trace import Trace, difference
from testbed import NODES, TIMEOUT_S, Testbed, single_server_trace

_ENV_COUNT = 256
_APART = 60  # Requests between a fault and its end, and between that and the next fault.
_RESTART = "kill the fleet server"
_LOST = "event=shard_lost"


def measure(kind: str, script: Script, folder: Path) -> tuple[Trace, list[float]]:
    """Returns the trace, and the pause at each fault that moved a shard."""
    hits = range(_APART, script.request_count - _APART, 2 * _APART)
    turns = set(hits) | {hit + _APART for hit in hits}
    moved: dict[int, bool] = {}
    with Testbed(folder) as testbed:
        driver = FaultDriver(testbed)
        learner = testbed.learner(script, announce=tuple(turns))
        hit, lost_before, host = 0, 0, FLEET
        while (request := learner.next_announced(TIMEOUT_S)) is not None:
            if request not in hits:
                moved[hit] = kind == _RESTART or testbed.fleet.log().count(_LOST) > lost_before
                if kind != _RESTART:
                    driver.undo(host)
                continue
            hit, lost_before = request, testbed.fleet.log().count(_LOST)
            if kind == _RESTART:
                driver.begin(Fault(request, FLEET, "kill"))
                driver.undo(FLEET)
                continue
            host = NODES[len(moved) % len(NODES)]
            driver.begin(Fault(request, host, kind))
        trace = learner.trace(TIMEOUT_S)
    pauses = [float(trace.durations[hit : hit + _APART].max()) for hit in hits if moved[hit]]
    return trace, pauses


def main() -> None:
    """The program."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=6, help="faults of a kind (default: 6)")
    rounds = parser.parse_args().rounds
    count = _APART * (2 * rounds + 1)
    script = Script(request_count=count, env_count=_ENV_COUNT, games=["coinrun"], sent_ahead=1)
    with tempfile.TemporaryDirectory() as folder:
        expected = single_server_trace(script, Path(folder))
    print("| what happens | faults | pause p50 | pause max | other answers, p50 |")
    print("| --- | --- | --- | --- | --- |")
    for kind in (*KINDS, _RESTART):
        with tempfile.TemporaryDirectory() as folder:
            trace, pauses = measure(kind, script, Path(folder))
        found = difference(expected, trace)
        assert found is None, f"{kind}: {found}"
        usual = statistics.median(trace.durations) * 1000
        p50 = f"{statistics.median(pauses):.2f} s | {max(pauses):.2f} s" if pauses else "- | -"
        print(f"| {kind} | {len(pauses)} | {p50} | {usual:.0f} ms |", flush=True)


if __name__ == "__main__":
    main()
