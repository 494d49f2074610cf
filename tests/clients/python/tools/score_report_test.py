"""The plot of an evaluation shows its scores."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from procgen_client import Client
from procgen_client.tools import evaluation, score_report


def test_bars_are_the_scores_with_their_intervals(
    client: Client, tmp_path: Path, saved_figures: list[Any]
) -> None:
    protocol = evaluation.Protocol(mode="easy", train_levels=3, episode_count=12, env_count=4)
    result = evaluation.evaluate(client, ["bigfish", "maze"], evaluation.random_policy, protocol)
    score_report.plot(result, "random", str(tmp_path / "scores.png"))
    assert (tmp_path / "scores.png").read_bytes().startswith(b"\x89PNG")
    (axes,) = saved_figures[0].axes
    assert [text.get_text() for text in axes.get_legend().get_texts()] == [
        "levels 0 to 2 (training)",
        "all levels",
    ]
    assert [label.get_text().split("\n")[0] for label in axes.get_xticklabels()] == [
        "bigfish",
        "maze",
        "interquartile",
    ]
    for bars, levels in zip(axes.containers[1::2], ("train", "test"), strict=True):
        scores = [getattr(game, levels) for game in result.games]
        overall = getattr(result, levels)
        expected = [*(score.score for score in scores), overall.interquartile_mean]
        assert [bar.get_height() for bar in bars] == pytest.approx(expected)
        intervals = [*(score.score_interval for score in scores)]
        intervals.append(overall.interquartile_mean_interval)
        lines = bars.errorbar.lines[2][0].get_segments()
        for line, height, (low, high) in zip(lines, expected, intervals, strict=True):
            shown = [min(low, height), max(high, height)]
            assert line[:, 1] == pytest.approx(shown)
