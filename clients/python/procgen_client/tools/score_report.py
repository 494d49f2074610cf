"""The results of an evaluation as a table, a figure and JSON."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from procgen_client.tools.evaluation import Aggregate, Evaluation, LevelSetScore


def table(evaluation: Evaluation) -> str:
    """Returns the scores as a Markdown table, with those over all games last."""
    protocol, (train, test) = evaluation.protocol, (evaluation.train, evaluation.test)
    lines = [
        f"{protocol.mode} mode; training levels are 0 ... {protocol.train_levels - 1}",
        "",
        "| game | episodes | return: training levels | all levels "
        "| score: training levels | all levels | gap |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    lines += [
        f"| {score.game} | {len(score.test.episodes)} "
        f"| {_return(score.train)} | {_return(score.test)} "
        f"| {_score(score.train.score, score.train.score_interval)} "
        f"| {_score(score.test.score, score.test.score_interval)} "
        f"| {score.train.score - score.test.score:.3f} |"
        for score in evaluation.games
    ]
    lines += [
        f"| mean | | | | {_score(train.mean, train.mean_interval)} "
        f"| {_score(test.mean, test.mean_interval)} | {train.mean - test.mean:.3f} |",
        f"| interquartile mean | | | "
        f"| {_score(train.interquartile_mean, train.interquartile_mean_interval)} "
        f"| {_score(test.interquartile_mean, test.interquartile_mean_interval)} "
        f"| {train.interquartile_mean - test.interquartile_mean:.3f} |",
    ]
    return "\n".join(lines)


def results(evaluation: Evaluation, policy: str) -> dict[str, Any]:
    """Returns the results for a JSON file: protocol, scores, and an entry per episode."""
    protocol = evaluation.protocol
    return {
        "policy": policy,
        "protocol": protocol._asdict() | {"options": dict(protocol.options)},
        "train": evaluation.train._asdict(),
        "test": evaluation.test._asdict(),
        "games": [
            {
                "game": score.game,
                "return_range": score.return_range,
                "train": _numbers(score.train),
                "test": _numbers(score.test),
            }
            for score in evaluation.games
        ],
        "episodes": [
            {
                "game": score.game,
                "mode": protocol.mode,
                "levels": levels,
                "level_seed": episode.level_seed,
                "return": episode.episode_return,
                "length": episode.length,
                "level_complete": episode.is_completed,
            }
            for score in evaluation.games
            for levels in ("train", "test")
            for episode in getattr(score, levels).episodes
        ],
    }


def plot(evaluation: Evaluation, policy: str, path: str) -> None:
    """Draws the scores as bars with confidence intervals; needs matplotlib."""
    from matplotlib.figure import Figure

    games, protocol = evaluation.games, evaluation.protocol
    figure = Figure(figsize=(max(5.0, 2.5 + 0.7 * len(games)), 4.5), layout="constrained")
    axes = figure.subplots()
    labels = [f"{it.game}\n{it.return_range[0]:g} to {it.return_range[1]:g}" for it in games]
    labels.append("interquartile\nmean")
    places = np.arange(len(labels))
    bars = {f"levels 0 to {protocol.train_levels - 1} (training)": "train", "all levels": "test"}
    for shift, (label, levels) in zip((-0.2, 0.2), bars.items()):
        scores: list[LevelSetScore] = [getattr(game, levels) for game in games]
        overall: Aggregate = getattr(evaluation, levels)
        heights = [*(score.score for score in scores), overall.interquartile_mean]
        intervals = [
            *(score.score_interval for score in scores),
            overall.interquartile_mean_interval,
        ]
        low, high = np.array(intervals).T
        # An interval of percentiles need not contain the mean of few episodes.
        errors = np.maximum([heights - low, high - heights], 0)
        axes.bar(places + shift, heights, 0.4, label=label, yerr=errors, capsize=2)
    axes.set_xticks(places, labels, rotation=45, ha="right")
    axes.set_ylabel("normalised return\n0 and 1: the returns under each name")
    for height in (0, 1):
        axes.axhline(height, color="black", linewidth=0.8, linestyle="-" if height == 0 else ":")
    count = min(len(game.test.episodes) for game in games)
    axes.set_title(f"{policy}, {protocol.mode} mode\n{count} episodes per bar, 95 % confidence")
    axes.legend(fontsize="small")
    figure.savefig(path)


def _return(score: LevelSetScore) -> str:
    error = score.return_standard_error
    return f"{score.return_mean:.2f}" + ("" if math.isnan(error) else f" ± {error:.2f}")


def _score(score: float, interval: tuple[float, float]) -> str:
    return f"{score:.3f} [{interval[0]:.3f}, {interval[1]:.3f}]"


def _numbers(score: LevelSetScore) -> dict[str, Any]:
    numbers = score._asdict()
    del numbers["episodes"]
    if math.isnan(score.return_standard_error):  # JSON has no NaN.
        numbers["return_standard_error"] = None
    return numbers
