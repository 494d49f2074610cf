#!/usr/bin/env python3
"""Prints the results of procgen-benchmark-stream as a table and draws them as a plot.

Usage: stream_report.py STREAM.json [--plot FILE.png]

STREAM.json is the output of the program with --benchmark_format=json. The table, in Markdown, goes
to standard output; README.md in this folder contains it. The plot needs matplotlib
(deploy/install-dependencies.sh --plot).
Exit status: 0 success, 2 invalid arguments or file, 77 --plot without matplotlib.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from pathlib import Path
from typing import NamedTuple

_NAME = re.compile(r"(?P<case>[a-z/]+)/(?:environments|learners):(?P<size>\d+)(?:/manual_time)?$")
_NOT_INSTALLED = 77
_DOTS_PER_INCH = 120
_TCP_SIZES_WITH_TARGET = (64, 256)
_COLORS = {"ours": "#2a6f97", "bound": "#adb5bd", "tail": "#90c2e0"}


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


def plot(report: Report, path: Path) -> None:
    """Plots the rate ratios of the streams, the latencies and the shares side by side."""
    import matplotlib

    matplotlib.use("Agg")
    matplotlib.rcParams["font.size"] = 9
    from matplotlib import pyplot

    figure, (streams, latencies, shares) = pyplot.subplots(
        1, 3, figsize=(10, 2.8), width_ratios=(5, 2, 3), layout="constrained"
    )
    for axes in (streams, latencies, shares):
        axes.spines[["top", "right"]].set_visible(False)
    _plot_streams(report, streams)
    _plot_latencies(report, latencies)
    _plot_shares(report, shares)
    figure.savefig(path, dpi=_DOTS_PER_INCH)


def _plot_streams(report: Report, axes) -> None:  # noqa: ANN001
    tcp = report.sizes("stream/tcp")
    names = [f"TCP\n{size}" for size in tcp]
    ratios = [report.cases["stream/tcp", size]["allowed_ratio"] for size in tcp]
    axes.bar(names, ratios, color=_COLORS["ours"], label="separate cores")
    shared = [report.cases["stream/tcp", size]["shared_allowed_ratio"] for size in tcp]
    axes.scatter(names, shared, color="black", zorder=2, s=14, label="shared cores")
    axes.axhline(1, color=_COLORS["bound"], linestyle="--", linewidth=1)
    axes.set_title("stream: rate / upper bound")
    axes.set_ylim(0, None)
    axes.legend(frameon=False, fontsize=7, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.15))


def _plot_latencies(report: Report, axes) -> None:  # noqa: ANN001
    axes.set_title("round trip, us: p50, p99")
    if ("latency", 1) not in report.cases:
        return
    case = report.cases["latency", 1]
    p50, p99 = case["p50_us"], case["p99_us"]
    bare = (p50 / case["pingpong_ratio"], p99 / case["pingpong_p99_ratio"])
    places = (0, 1)
    axes.bar(places, (bare[1], p99), color=_COLORS["tail"])
    axes.bar(places, (bare[0], p50), color=(_COLORS["bound"], _COLORS["ours"]))
    axes.set_xticks(places, ("empty\nping-pong", "one\nenvironment"))


def _plot_shares(report: Report, axes) -> None:  # noqa: ANN001
    sizes = report.sizes("fair")
    least = [report.cases["fair", size]["least_share"] for size in sizes]
    most = [report.cases["fair", size]["most_share"] for size in sizes]
    axes.vlines(range(len(sizes)), least, most, color=_COLORS["ours"], linewidth=5)
    axes.scatter(range(len(sizes)), least, color=_COLORS["ours"], s=14)
    axes.scatter(range(len(sizes)), most, color=_COLORS["ours"], s=14)
    axes.axhspan(0.8, 1.2, color=_COLORS["bound"], alpha=0.3, zorder=0)
    axes.set_xticks(range(len(sizes)), [str(size) for size in sizes])
    axes.set_xlim(-0.5, len(sizes) - 0.5)
    axes.set_ylim(min(0.5, *least), max(1.5, *most))
    axes.set_title("concurrent learners: share of each")


def main() -> int:
    """Runs the program; returns its exit status."""
    parser = argparse.ArgumentParser(
        description="Prints the results of procgen-benchmark-stream as a Markdown table."
    )
    parser.add_argument("run", metavar="STREAM.json", type=Path,
                        help="output of the program with --benchmark_format=json")
    parser.add_argument("--plot", metavar="FILE.png", type=Path, help="also write this plot")
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
    if arguments.plot:
        try:
            plot(report, arguments.plot)
        except ImportError:
            print("stream_report.py: matplotlib is not installed: "
                  "deploy/install-dependencies.sh --plot", file=sys.stderr)
            return _NOT_INSTALLED
    print(table(report.rows()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
