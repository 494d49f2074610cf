"""The plot and the table of an experiment show its runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from learners import published, report


def _run(
    game: str, seed: int, returns: list[float], tests: list[float], levels: int = 200
) -> report.Run:
    def steps(values: list[float]) -> np.ndarray:
        return 512 * np.arange(1, len(values) + 1)

    curves = (steps(returns), np.array(returns), steps(tests), np.array(tests))
    return report.Run(game, "PPO", seed, levels, *curves, {})


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.split("|")[1:-1]]


def test_curves_are_the_mean_and_range_of_seeds(
    tmp_path: Path, saved_figures: list[Any]
) -> None:
    runs = [
        _run("coinrun", 0, [5.0, 6.0, 7.0], [4.5]),
        _run("coinrun", 1, [7.0, 8.0, 9.0, 9.5], [5.5]),
        _run("maze", 0, [5.0, 5.0, 10.0], []),
        _run("maze", 1, [5.0, 7.5, 10.0], []),
    ]
    openai = {"train": {512: {"return": published.Measured(4.0, 1.0)}, 9999: {}}}
    runs[0] = runs[0]._replace(published=openai)
    ranges: dict[str, report.Range | None] = {"coinrun": (5, 10), "maze": (5, 10)}
    path = tmp_path / "curves.png"
    report.plot(runs, ranges, "levels", path)

    assert path.read_bytes().startswith(b"\x89PNG")
    coinrun, maze, mean = (axes for axes in saved_figures[0].axes if axes.axison)
    titles = [axes.get_title() for axes in (coinrun, maze, mean)]
    assert titles == ["coinrun", "maze", "mean, normalised"]
    curve, tested, openai_curve = coinrun.lines
    assert curve.get_label() == "PPO"
    assert curve.get_xydata().tolist() == [[512, 6], [1024, 7], [1536, 8]]
    assert tested.get_xydata().tolist() == [[512, 5]]
    assert openai_curve.get_xydata().tolist() == [[512, 4]]
    area = coinrun.collections[0].get_paths()[0].vertices[:, 1]
    assert (area.min(), area.max()) == (5, 9)
    assert maze.lines[0].get_ydata().tolist() == [5, 6.25, 10]
    # Normalised: coinrun 0.2, 0.4, 0.6 and maze 0, 0.25, 1.
    assert mean.lines[0].get_ydata().tolist() == pytest.approx([0.1, 0.325, 0.8])


def test_returns_are_plotted_over_numbers_of_levels(
    tmp_path: Path, saved_figures: list[Any]
) -> None:
    runs = [
        _run("coinrun", seed, [train], [test], levels)
        for levels, seed, train, test in [
            *((1000, 0, 8.0, 7.0), (1000, 1, 9.0, 8.0)),
            *((10, 0, 10.0, 3.0), (10, 1, 10.0, 4.0)),
        ]
    ]
    report.plot_levels(runs, "levels", tmp_path / "levels.png")
    (axes,) = saved_figures[0].axes
    assert axes.get_xscale() == "log"
    train, test = axes.lines
    assert (train.get_label(), test.get_label()) == ("training levels", "all")
    assert train.get_xydata().tolist() == [[10, 10], [1000, 8.5]]
    assert test.get_xydata().tolist() == [[10, 3.5], [1000, 7.5]]


def test_table_has_the_mean_of_the_last_tenth_of_the_training() -> None:
    late = [float("nan")] * 10 + [9.0] * 8 + [3.0, 4.0, 5.0]
    runs = [_run("coinrun", 0, late, []), _run("maze", 0, [float("nan")], [])]
    lines = report.table(runs, {"coinrun": (0, 10), "maze": None}).splitlines()
    coinrun, maze = map(_cells, lines[2:4])
    assert coinrun[4] == "4.00"
    assert maze[4] == "", "no episode had ended"


def test_table_has_deviations_and_intervals() -> None:
    runs = [
        _run("maze", 0, [6.0], [5.0]),
        _run("maze", 1, [8.0], [6.0]),
        _run("coinrun", 0, [10.0], [7.5]),
        _run("coinrun", 1, [10.0], [7.5]),
        _run("heist", 0, [], []),
    ]
    ranges: dict[str, report.Range | None] = {}
    ranges |= dict.fromkeys(("maze", "coinrun", "heist"), (5.0, 10.0))
    maze, coinrun, heist, mean, middle = map(
        _cells, report.table(runs, ranges).splitlines()[2:]
    )
    assert maze[2:] == ["2", "0.000512", "7.00 ± 1.41", "5.50 ± 0.71", "0.40", "0.10"]
    assert coinrun[4:] == ["10.00 ± 0.00", "7.50 ± 0.00", "1.00", "0.50"]
    assert heist[2:] == ["0", "", "not run", "not run", "", ""]
    assert mean[:3] == ["mean", "PPO", "2 games"]
    assert mean[6:] == ["0.70 (0.60 to 0.80)", "0.30 (0.25 to 0.35)"]
    # Of 0.2, 0.6, 1.0 and 1.0 the middle half.
    assert middle[0] == "interquartile mean"
    assert middle[6].startswith("0.80 (")


def test_openai_is_compared_at_the_last_step_of_a_run() -> None:
    rows = published.by_step("fruitbot", "easy", 200, "train")
    run = _run("fruitbot", 0, [1.0] * 480, [])._replace(published={"train": rows})  # 245,760 steps.
    assert run.openai("train") == rows[250_000]["return"]
    assert run._replace(steps=run.steps[:400]).openai("train") is None
    assert run._replace(steps=run.steps[:0]).openai("train") == rows[25_000_000]["return"]


def test_published_results_are_those_of_the_protocol() -> None:
    row = published.by_step("bigfish", "easy", 200, "test")[25_000_000]
    assert str(row["return"]) == "4.72 ± 0.69"
    assert published.by_step("bigfish", "easy", 0, "test")[25_000_000]["return"].mean > 20
    assert not published.by_step("bigfish", "easy", 10, "train")
    steps, values = np.array([10, 90, 91, 100, 101]), np.array([9.0, 9, 1, 3, 9])
    assert published.window_mean(steps, values, 100) == 2
    assert np.isnan(published.window_mean(steps, values, 5))
