"""Figures and tables of an experiment's runs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from learners.published import Measured, Row
from procgen_client.tools.score_statistics import confidence_interval, interquartile_mean

Range = tuple[float, float]  # Returns that are normalised to 0 and 1.
_RESAMPLE_COUNT = 2000


class Run(NamedTuple):
    """The results of a run; without rows if it was not run."""

    game: str
    label: str  # The variant's.
    seed: int
    levels: int  # Number of training levels; 0: all.
    steps: np.ndarray  # [updates]
    returns: np.ndarray  # Mean of the last episodes; NaN before the first   [updates]
    test_steps: np.ndarray  # [tests]
    test_returns: np.ndarray  # On all levels   [tests]
    # Of OpenAI's runs of the same protocol, by "train" or "test" and step.
    published: dict[str, dict[int, Row]]

    def last(self, split: str) -> float:
        """Returns the mean over the last tenth of "train" or "test"; NaN: there is none."""
        is_test = split == "test"
        steps, returns = (
            (self.test_steps, self.test_returns) if is_test else (self.steps, self.returns)
        )
        if not steps.size:
            return float("nan")
        ended = returns[(steps >= 0.9 * self.steps[-1]) & ~np.isnan(returns)]
        return float(ended.mean()) if ended.size else float("nan")

    def openai(self, split: str) -> Measured | None:
        """Returns OpenAI's return near the run's last step, or if not run, after all steps."""
        rows = self.published.get(split, {})
        if self.steps.size:
            last = self.steps[-1]
            rows = {step: row for step, row in rows.items() if 0.8 * last <= step <= 1.02 * last}
        return rows[max(rows)]["return"] if rows else None


def table(runs: Sequence[Run], ranges: dict[str, Range | None]) -> str:
    """Returns the runs as a Markdown table: means and standard deviations over seeds."""
    splits = ["train"] + ["test"] * any(run.levels for run in runs)
    compares = any(run.published for run in runs)
    head = ["game", "variant", "seeds", "million steps"]
    for split in splits:
        head += ["training" if split == "train" else "all levels"]
        head += [f"{head[-1]}, OpenAI"] if compares else []
    head += ["normalised"] + ["normalised, all levels"] * (len(splits) - 1)
    lines = [_line(head), _line(["---", "---"] + ["---:"] * (len(head) - 2))]
    scores: dict[str, list[list[np.ndarray]]] = {}  # By label: of each game, of each split.
    for game, label in _unique((run.game, run.label) for run in runs):
        its_runs = [run for run in runs if (run.game, run.label) == (game, label)]
        done = [run for run in its_runs if run.steps.size]
        steps = f"{np.mean([run.steps[-1] for run in done]) / 1e6:.3g}" if done else ""
        cells = [game, label, str(len(done)), steps]
        for split in splits:
            cells.append(_spread([run.last(split) for run in done]) if done else "not run")
            cells += [str(its_runs[0].openai(split) or "")] if compares else []
        scaled = [
            _normalized(np.array([run.last(split) for run in done]), ranges[game])
            for split in splits
        ]
        if done:
            scores.setdefault(label, []).append(scaled)
        lines.append(_line([*cells, *(_number(_mean(values)) for values in scaled)]))
    for label, of_games in scores.items():
        if len(of_games) > 1:
            blank = [""] * (len(head) - 3 - len(splits))
            by_split = list(zip(*of_games, strict=True))
            statistics = {"mean": _last_axis_mean, "interquartile mean": interquartile_mean}
            for name, statistic in statistics.items():
                cells = [_aggregate(values, statistic) for values in by_split]
                count = f"{len(of_games)} games"
                lines.append(_line([name, label, count, *blank, *cells]))
    return "\n".join(lines)


def _aggregate(strata: Sequence[np.ndarray], statistic: Any) -> str:  # noqa: ANN401
    """Returns a statistic of all scores, with the 95 % interval of a bootstrap over runs.

    `strata`: scores of the runs of each game. As rliable (Agarwal et al., 2021); games with one
    run have no interval.
    """
    value = float(statistic(np.concatenate(strata)))
    if np.isnan(value) or min(map(len, strata)) < 2:
        return _number(value)
    random = np.random.default_rng(0)
    samples = [
        values[random.integers(0, len(values), (_RESAMPLE_COUNT, len(values)))]
        for values in strata
    ]
    low, high = confidence_interval(statistic(np.concatenate(samples, -1)))
    return f"{value:.2f} ({low:.2f} to {high:.2f})"


def _last_axis_mean(values: np.ndarray) -> np.ndarray:
    return values.mean(-1)


def plot(runs: Sequence[Run], ranges: dict[str, Range | None], title: str, path: Path) -> None:
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
            of_game = [run for run in its_runs if run.game == game]
            curves = [(run.steps, run.returns) for run in of_game]
            if game not in games:
                curves = _normalized_means(its_runs, ranges)
            _draw(axes, curves, f"C{color}", label)
            tests = [(run.test_steps, run.test_returns) for run in of_game if run.test_steps.size]
            _draw(axes, tests, f"C{color}", None, linestyle="--")
            if of_game:
                _draw_published(axes, of_game[0])
    grid[0].legend(fontsize="small")
    figure.suptitle(f"{title}\n(dashed: all levels; grey: OpenAI's runs)", fontsize=9)
    figure.savefig(path, dpi=120)


def _draw_published(axes: Any, run: Run) -> None:  # noqa: ANN401
    """Shades the mean of OpenAI's runs and a standard deviation around it."""
    for split, rows in run.published.items():
        steps = [step for step in rows if step <= 1.02 * run.steps[-1]]
        means = np.array([rows[step]["return"].mean for step in steps])
        deviations = np.array([rows[step]["return"].deviation for step in steps])
        style = {"color": "gray", "linestyle": "--" if split == "test" else "-"}
        axes.plot(steps, means, linewidth=0.8, **style)
        axes.fill_between(steps, means - deviations, means + deviations, color="gray", alpha=0.2)


def plot_levels(runs: Sequence[Run], title: str, path: Path) -> None:
    """Plots the last returns over numbers of training levels; as :func:`plot`."""
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
        for color, (label, split) in enumerate([("training levels", "train"), ("all", "test")]):
            seeds = zip(
                *([run.last(split) for run in by_levels[count]] for count in levels), strict=False
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
    label: str | None,
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


def _normalized(values: np.ndarray, its_range: Range | None) -> np.ndarray:
    if its_range is None:
        return np.full_like(values, np.nan)
    low, high = its_range
    return (values - low) / (high - low)


def _mean(values: np.ndarray) -> float:
    return float(np.mean(values)) if values.size else float("nan")


def _spread(values: Sequence[float]) -> str:
    """Returns the mean, and the standard deviation of several values."""
    if len(values) == 1:
        return _number(values[0])
    return str(Measured(float(np.mean(values)), float(np.std(values, ddof=1))))


def _number(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.2f}"


def _line(cells: Iterable[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _unique(values: Any) -> Any:  # noqa: ANN401 - of any type, in order
    return dict.fromkeys(values)
