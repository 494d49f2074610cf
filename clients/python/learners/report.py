"""Figures and tables of an experiment's runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

Range = tuple[float, float]  # Returns that are normalised to 0 and 1.


class Run(NamedTuple):
    """The results of a run."""

    game: str
    label: str  # The variant's.
    seed: int
    steps: np.ndarray  # [updates]
    returns: np.ndarray  # Mean of the last episodes; NaN before the first   [updates]
    train_return: float | None  # Of the trained policy on the training levels.
    test_return: float | None  # On the test levels.
    levels: int = 0  # Number of training levels; 0: all.


def table(
    runs: Sequence[Run], ranges: dict[str, Range | None], random: dict[str, list[float]]
) -> str:
    """Returns the runs as a Markdown table: means over seeds, with their range."""
    has_test = any(run.test_return is not None for run in runs)
    head = ["game", "variant", "seeds", "last tenth of training"]
    head += ["train levels", "test levels"] if has_test else []
    head += ["random agent"] if random else []
    head += ["normalised"] + (["normalised, test"] if has_test else [])
    lines = [_line(head), _line(["---", "---"] + ["---:"] * (len(head) - 2))]
    normalized: dict[str, list[list[float]]] = {}
    for game, label in _unique((run.game, run.label) for run in runs):
        its_runs = [run for run in runs if (run.game, run.label) == (game, label)]
        columns: list[Callable[[Run], Any]] = [_last]
        if has_test:
            columns += [lambda run: run.train_return, lambda run: run.test_return]
        means = [[column(run) for run in its_runs] for column in columns]
        cells = [game, label, str(len(its_runs)), *map(_spread, means)]
        cells += [_spread(random[game])] if random else []
        scaled = [
            _normalized(float(np.mean(means[column])), ranges[game])
            for column in ([0, 2] if has_test else [0])
        ]
        normalized.setdefault(label, []).append(scaled)
        lines.append(_line([*cells, *(_number(value) for value in scaled)]))
    if len({run.game for run in runs}) > 1:
        for label, rows in normalized.items():
            blank = [""] * (len(head) - 2 - len(rows[0]))
            means_of_label = np.mean(rows, 0)
            lines.append(_line(["mean", label, *blank, *map(_number, means_of_label)]))
    return "\n".join(lines)


def plot(
    runs: Sequence[Run],
    ranges: dict[str, Range | None],
    random: dict[str, list[float]],
    title: str,
    path: Path,
) -> None:
    """Plots returns over steps, per game and their mean; nothing without matplotlib."""
    games = list(_unique(run.game for run in runs))
    labels = list(_unique(run.label for run in runs))
    # No mean if a game has no constants in this mode.
    pictures = [*games, "mean, normalised"] if all(ranges[game] for game in games) else games
    figure, grid = _grid(pictures, path)
    if figure is None:
        return
    for axes, game in zip(grid, pictures, strict=True):
        axes.ticklabel_format(axis="x", scilimits=(0, 0))
        for color, label in enumerate(labels):
            its_runs = [run for run in runs if run.label == label]
            if game in games:
                curves = [(run.steps, run.returns) for run in its_runs if run.game == game]
            else:
                curves = _normalized_means(its_runs, ranges)
            _draw(axes, curves, f"C{color}", label)
            for run in its_runs:
                if run.game == game and run.test_return is not None:
                    axes.plot(run.steps[-1], run.test_return, "o", color=f"C{color}")
        for value in random.get(game, []):
            axes.axhline(value, color="gray", linewidth=0.8)
    grid[0].legend(fontsize="small")
    figure.suptitle(f"{title}\n(dots: test levels; grey: random agent)", fontsize=9)
    figure.savefig(path, dpi=120)


def plot_levels(runs: Sequence[Run], title: str, path: Path) -> None:
    """Plots trained policies' returns over numbers of training levels; as :func:`plot`."""
    games = list(_unique(run.game for run in runs))
    figure, grid = _grid(games, path)
    if figure is None:
        return
    for axes, game in zip(grid, games, strict=True):
        by_levels: dict[int, list[Run]] = {}
        for run in runs:
            if run.game == game:
                by_levels.setdefault(run.levels, []).append(run)
        levels = np.array(sorted(by_levels))
        for color, (label, column) in enumerate(
            [("training levels", "train_return"), ("all levels", "test_return")]
        ):
            seeds = zip(
                *([getattr(run, column) for run in by_levels[count]] for count in levels),
                strict=True,
            )
            curves = [(levels, np.array(returns)) for returns in seeds]
            _draw(axes, curves, f"C{color}", label, marker="o")
        axes.set_xscale("log")
        axes.set_xlabel("training levels")
    grid[0].legend(fontsize="small")
    figure.suptitle(title, fontsize=9)
    figure.savefig(path, dpi=120)


def _grid(titles: Sequence[str], path: Path) -> tuple[Any, list[Any]]:
    """Returns a figure and its axes, one for each title; None and [] without matplotlib."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        print(f"matplotlib is not installed: {path} is not drawn")
        return None, []
    columns = min(4, len(titles))
    rows = -(-len(titles) // columns)
    figure = Figure(figsize=(3.6 * columns, 2.8 * rows), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in grid[len(titles) :]:
        axes.set_axis_off()
    for axes, title in zip(grid, titles, strict=False):
        axes.set_title(title)
    return figure, list(grid[: len(titles)])


def _draw(
    axes: Any,  # noqa: ANN401
    curves: Sequence[tuple[np.ndarray, np.ndarray]],
    color: str,
    label: str,
    **style: Any,  # noqa: ANN401 - of matplotlib
) -> None:
    """Plots the mean of curves, and shades their range."""
    if not curves:
        return
    length = min(len(steps) for steps, _ in curves)
    steps = curves[0][0][:length]
    returns = np.stack([returns[:length] for _, returns in curves])
    axes.plot(steps, returns.mean(0), color=color, label=label, **style)
    if len(curves) > 1:
        axes.fill_between(steps, returns.min(0), returns.max(0), color=color, alpha=0.25)


def _normalized_means(
    runs: Sequence[Run], ranges: dict[str, Range | None]
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Returns the mean normalised returns for each seed that all games have."""
    games = list(_unique(run.game for run in runs))
    curves = []
    for seed in sorted({run.seed for run in runs}):
        its_runs = [run for run in runs if run.seed == seed]
        if len(its_runs) == len(games):
            length = min(len(run.steps) for run in its_runs)
            scaled = [_normalized(run.returns[:length], ranges[run.game]) for run in its_runs]
            curves.append((its_runs[0].steps[:length], np.mean(scaled, 0)))
    return curves


def _normalized(value: Any, its_range: Range | None) -> Any:  # noqa: ANN401
    if its_range is None:
        return np.nan
    low, high = its_range
    return (value - low) / (high - low)


def _last(run: Run) -> float:
    """Returns the mean over the last tenth of the training; NaN: no episode had ended."""
    returns = run.returns[run.steps >= 0.9 * run.steps[-1]]
    ended = returns[~np.isnan(returns)]
    return float(ended.mean()) if ended.size else float("nan")


def _spread(values: Sequence[float]) -> str:
    """Returns the mean, and the range of several values."""
    mean = _number(float(np.mean(values)))
    return f"{mean} ({min(values):.2f} to {max(values):.2f})" if len(values) > 1 else mean


def _number(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.2f}"


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _unique(values: Any) -> Any:  # noqa: ANN401 - of any type, in order
    return dict.fromkeys(values)
