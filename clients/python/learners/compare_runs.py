"""Compares the episodes of two runs: step, environment, level seed, return and length.

    python3 -m learners.compare_runs runs/here runs/upstream

Prints the first difference and exits with status 1 if they differ. `python3 -m learners.upstream`
makes a run on upstream's package, with the options of learners.ppo.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from learners.training_run import EPISODE_COLUMNS


class Comparison(NamedTuple):
    """The result of a comparison."""

    equal_count: int  # Episodes before the first difference, or before the shorter run's end.
    step: int  # Up to which the runs are equal.
    difference: str  # The first difference; empty: none.


def read_episodes(run: Path) -> list[tuple[float, ...]]:
    """Returns the rows of a run's episodes.csv.

    Raises:
        SystemExit: There is no such file, or it has other columns.
    """
    path = run / "episodes.csv"
    try:
        with open(path, newline="") as file:
            header, *rows = csv.reader(file)
    except (OSError, ValueError) as error:
        raise SystemExit(f"{path}: {error}") from error
    if tuple(header) != EPISODE_COLUMNS:
        raise SystemExit(f"{path} has columns {','.join(header)}, not {','.join(EPISODE_COLUMNS)}")
    return [tuple(map(float, row)) for row in rows]


def compare(one: list[tuple[float, ...]], other: list[tuple[float, ...]]) -> Comparison:
    """Compares the episodes of two runs up to the end of the shorter one."""
    last_common_step = min(one[-1][0], other[-1][0]) if one and other else 0
    for number, rows in enumerate(zip(one, other, strict=False)):
        if rows[0] != rows[1]:
            return Comparison(number, int(one[number - 1][0]) if number else 0, _difference(*rows))
    count = min(len(one), len(other))
    longer = max(one, other, key=len)
    if len(longer) > count and longer[count][0] <= last_common_step:
        return Comparison(
            count, int(last_common_step), f"one run has another episode: {_shown(longer[count])}"
        )
    return Comparison(count, int(last_common_step), "")


def _difference(one: tuple[float, ...], other: tuple[float, ...]) -> str:
    return f"{_shown(one)}\n{_shown(other)}"


def _shown(row: tuple[float, ...]) -> str:
    return ", ".join(f"{name} {value:g}" for name, value in zip(EPISODE_COLUMNS, row, strict=True))


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line; returns the exit status, 1 if the runs differ."""
    parser = argparse.ArgumentParser(
        prog="python3 -m learners.compare_runs",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("runs", nargs=2, type=Path, metavar="DIR")
    runs = parser.parse_args(arguments).runs
    comparison = compare(*map(read_episodes, runs))
    print(f"{comparison.equal_count} episodes are equal, to step {comparison.step}")
    if comparison.difference:
        print(f"then they differ:\n{comparison.difference}")
    return 1 if comparison.difference or not comparison.equal_count else 0


if __name__ == "__main__":
    sys.exit(main())
