"""The plot and the table of an experiment show its runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from learners import report


def _run(game: str, seed: int, returns: list[float], test_return: float | None) -> report.Run:
    steps = 512 * np.arange(1, len(returns) + 1)
    return report.Run(game, "200 levels", seed, steps, np.array(returns), 2.0, test_return)


def test_curves_are_the_mean_and_range_of_seeds(
    tmp_path: Path, saved_figures: list[Any]
) -> None:
    runs = [
        _run("coinrun", 0, [5.0, 6.0, 7.0], 4.5),
        _run("coinrun", 1, [7.0, 8.0, 9.0, 9.5], 5.5),
        _run("maze", 0, [5.0, 5.0, 10.0], None),
        _run("maze", 1, [5.0, 7.5, 10.0], None),
    ]
    ranges: dict[str, report.Range | None] = {"coinrun": (5, 10), "maze": (5, 10)}
    path = tmp_path / "curves.png"
    report.plot(runs, ranges, {"coinrun": [2.5, 3.0]}, "levels", path)

    assert path.read_bytes().startswith(b"\x89PNG")
    coinrun, maze, mean = (axes for axes in saved_figures[0].axes if axes.axison)
    assert [axes.get_title() for axes in (coinrun, maze, mean)] == [
        "coinrun",
        "maze",
        "mean, normalised",
    ]
    curve, *others = coinrun.lines
    assert curve.get_label() == "200 levels"
    assert curve.get_xydata().tolist() == [[512, 6], [1024, 7], [1536, 8]]
    shown = [(line.get_xdata()[0], line.get_ydata()[0]) for line in others]
    assert shown == [(1536, 4.5), (2048, 5.5), (0, 2.5), (0, 3.0)], "test levels, random agents"
    area = coinrun.collections[0].get_paths()[0].vertices[:, 1]
    assert (area.min(), area.max()) == (5, 9)
    assert maze.lines[0].get_ydata().tolist() == [5, 6.25, 10]
    # Normalised: coinrun 0.2, 0.4, 0.6 and maze 0, 0.25, 1.
    assert mean.lines[0].get_ydata().tolist() == pytest.approx([0.1, 0.325, 0.8])


def test_returns_are_plotted_over_numbers_of_levels(
    tmp_path: Path, saved_figures: list[Any]
) -> None:
    steps, returns = np.array([512]), np.array([5.0])
    runs = [
        report.Run("coinrun", f"{levels} levels", seed, steps, returns, *tested, levels)
        for levels, seed, tested in [
            (1000, 0, (8.0, 7.0)),
            (1000, 1, (9.0, 8.0)),
            (10, 0, (10.0, 3.0)),
            (10, 1, (10.0, 4.0)),
        ]
    ]
    report.plot_levels(runs, "levels", tmp_path / "levels.png")
    (axes,) = saved_figures[0].axes
    assert axes.get_xscale() == "log"
    train, test = axes.lines
    assert (train.get_label(), test.get_label()) == ("training levels", "all levels")
    assert train.get_xydata().tolist() == [[10, 10], [1000, 8.5]]
    assert test.get_xydata().tolist() == [[10, 3.5], [1000, 7.5]]


def test_table_has_the_mean_of_the_last_tenth_of_the_training() -> None:
    late = [float("nan")] * 10 + [9.0] * 8 + [3.0, 4.0, 5.0]
    runs = [_run("coinrun", 0, late, None), _run("maze", 0, [float("nan")], None)]
    lines = report.table(runs, {"coinrun": (0, 10), "maze": None}, {}).splitlines()
    coinrun, maze = ([cell.strip() for cell in line.split("|")] for line in lines[2:4])
    assert coinrun[4] == "4.00"
    assert maze[4] == "", "no episode had ended"
