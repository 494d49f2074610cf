#!/usr/bin/env python3
"""Prints the results of procgen-benchmark-stream as a table in Markdown.

Usage: stream_report.py STREAM.json

STREAM.json is the output of the program with --benchmark_format=json. README.md in this folder
contains the table. Exit status: 0 success, 2 invalid arguments or file.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from pathlib import Path
from typing import NamedTuple

_NAME = re.compile(r"(?P<case>[a-z/]+)/(?:environments|learners):(?P<size>\d+)(?:/manual_time)?$")
_TCP_SIZES_WITH_TARGET = (64, 256)


class Row(NamedTuple):
    """A row of the table: the measurement, its target and its result."""

    what: str
    target: str
    figure: str


class Report:
    """The cases of one run by name and size, e.g. ("stream/tcp", 64)."""

    def __init__(self, run: dict) -> None:
        """Reads the parsed output of the program."""
        self.cases: dict[tuple[str, int], dict[str, float]] = {}
        for benchmark in run["benchmarks"]:
            name = _NAME.match(benchmark["name"])
            if name and not benchmark.get("error_occurred"):
                self.cases[name["case"], int(name["size"])] = benchmark

    def sizes(self, case: str) -> list[int]:
        """Returns the sizes of a case in this run, ascending."""
        return sorted(size for name, size in self.cases if name == case)

    def rows(self) -> list[Row]:
        """Returns the rows of the table, for the cases in this run."""
        rows: list[Row] = []
        for size in self.sizes("stream/tcp"):
            case = self.cases["stream/tcp", size]
            rows.append(
                Row(
                    f"TCP, pool of {size}: rate / slower of engine and wire "
                    "(/ bound on shared cores)",
                    "0.85" if size in _TCP_SIZES_WITH_TARGET else "",
                    f"{case['allowed_ratio']:.2f} ({case['shared_allowed_ratio']:.2f})",
                )
            )
        if ("latency", 1) in self.cases:
            case = self.cases["latency", 1]
            rows.append(
                Row("one environment's round trip: p50 / p50 of an empty ping-pong",
                    "at most 1.5",
                    f"{case['pingpong_ratio']:.2f} ({case['p50_us']:.0f} us; "
                    f"p99 {case['p99_us']:.0f} us)")
            )
        for size in filter(lambda count: count > 1, self.sizes("fair")):
            case = self.cases["fair", size]
            rows.append(
                Row(f"{size} learners at once: smallest to largest share / equal share",
                    "0.8 to 1.2",
                    f"{case['least_share']:.2f} to {case['most_share']:.2f}")
            )
        return rows


def table(rows: list[Row]) -> str:
    """Returns the rows as a Markdown table."""
    lines = ["| measurement | target | result |", "| --- | --- | --- |"]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in rows)])


def main() -> int:
    """Runs the program; returns its exit status."""
    parser = argparse.ArgumentParser(
        description="Prints the results of procgen-benchmark-stream as a Markdown table."
    )
    parser.add_argument("run", metavar="STREAM.json", type=Path,
                        help="output of the program with --benchmark_format=json")
    arguments = parser.parse_args()
    try:
        report = Report(json.loads(arguments.run.read_text()))
    except (OSError, ValueError, KeyError) as error:
        print(f"stream_report.py: {arguments.run} is not readable benchmark output: {error!r}",
              file=sys.stderr)
        return 2
    if not report.cases:
        print(f"stream_report.py: {arguments.run} has no case of procgen-benchmark-stream",
              file=sys.stderr)
        return 2
    print(table(report.rows()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
