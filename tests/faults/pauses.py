#!/usr/bin/env python3
"""Measures how long a learner of 256 environments waits when a server or its own network fails.

For each kind of fault, each round runs servers and a learner of their own. Prints a table of the
longest response time of a round: median and maximum over the rounds.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
from collections.abc import Sequence
from pathlib import Path

from faults import KINDS, Fault, play
from learner_script import Script
from learner_trace import Trace, difference
from testbed import LEARNER, SERVERS, Testbed, undisturbed_trace

_ENV_COUNT = 256
# One of three servers is lost for longer than its detection takes.
_LOST_S = 10.0
# What has no replacement is away for this long.
_AWAY_S = 3.0

_LEARNER_KINDS = ("cut both", "unplug")


def measure(
    hosts: Sequence[str],
    hit: str,
    kind: str,
    seconds: float,
    rounds: int,
    script: Script,
    expected: Trace,
) -> str:
    """Returns the numbers of a row: median and maximum of the pauses, median of other responses."""
    pauses, usual = [], []
    for number in range(rounds):
        with tempfile.TemporaryDirectory() as folder, Testbed(Path(folder), hosts) as testbed:
            # Each round hits another one of the servers.
            host = hosts[number % len(hosts)] if hit == "server" else hit
            fault = Fault(script.request_count // 2, host, kind, seconds)
            trace = play(testbed, script, [fault])
        found = difference(expected, trace)
        assert found is None, f"{kind}: {found}"
        pauses.append(float(trace.durations[fault.request :].max()))
        usual.append(statistics.median(trace.durations) * 1000)
    pause = f"{statistics.median(pauses):.2f} s | {max(pauses):.2f} s"
    return f"{pause} | {statistics.median(usual):.0f} ms"


def main() -> None:
    """The program."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3, help="faults of a kind (default: 3)")
    rounds = parser.parse_args().rounds
    script = Script(request_count=400, env_count=_ENV_COUNT, games=["coinrun"], sent_ahead=1)
    with tempfile.TemporaryDirectory() as folder:
        expected = undisturbed_trace(script, Path(folder))
    print("| what fails | fault | pause, median | pause, maximum | other responses, median |")
    print("| --- | --- | --- | --- | --- |")
    for name, hosts, hit, kinds, seconds in (
        ("one of three", SERVERS, "server", KINDS, _LOST_S),
        ("the only one", SERVERS[:1], "server", KINDS, _AWAY_S),
        ("the learner's host, three servers", SERVERS, LEARNER, _LEARNER_KINDS, _AWAY_S),
        ("the learner's host, one server", SERVERS[:1], LEARNER, _LEARNER_KINDS, _AWAY_S),
    ):
        for kind in kinds:
            row = measure(hosts, hit, kind, seconds, rounds, script, expected)
            print(f"| {name} | {kind} for {seconds:g} s | {row} |", flush=True)


if __name__ == "__main__":
    main()
