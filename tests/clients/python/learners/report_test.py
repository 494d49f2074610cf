"""The plot and the table of an experiment show its runs."""

from __future__ import annotations

from pathlib import Path

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
