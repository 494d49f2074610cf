"""Results of the runs that OpenAI published, to compare with.

results/openai_ppo.csv: the PPO runs of openai/train-procgen (MIT licence; Procgen 0.9.2, upstream's
art, IMPALA, 64 environments). Per protocol, split, game and step: mean and standard deviation over
three runs of the mean in the tenth before that step.
"""

from __future__ import annotations

import csv
import functools
from pathlib import Path
from typing import NamedTuple

PATH = Path(__file__).parent / "results" / "openai_ppo.csv"
COLUMNS = ("return", "length", "kl", "clip_fraction", "entropy", "policy_loss", "value_loss")
COLUMNS = (*COLUMNS, "explained_variance")


class Measured(NamedTuple):
    """Mean and standard deviation over runs."""

    mean: float
    deviation: float

    def __str__(self) -> str:
        """Returns e.g. 4.72 ± 0.69."""
        return f"{self.mean:.2f} ± {self.deviation:.2f}"


Row = dict[str, Measured]  # By COLUMNS.


@functools.cache
def _rows() -> dict[tuple[str, str, str], dict[int, Row]]:
    rows: dict[tuple[str, str, str], dict[int, Row]] = {}
    with open(PATH, newline="") as file:
        for line in csv.DictReader(file):
            row = {
                name: Measured(float(line[f"{name}_mean"]), float(line[f"{name}_std"]))
                for name in COLUMNS
            }
            key = line["protocol"], line["split"], line["game"]
            rows.setdefault(key, {})[round(float(line["million_steps"]) * 1e6)] = row
    return rows


def by_step(game: str, mode: str, levels: int, split: str) -> dict[int, Row]:
    """Returns the results at each step that has a row; empty: there are no such runs.

    Args:
        game: Name of the game.
        mode: Distribution mode.
        levels: Number of training levels; 0: all.
        split: "train", the training levels, or "test", all levels.
    """
    protocol = f"{mode}-{levels or 'all'}"
    if levels == 0:
        split = "all"
    return _rows().get((protocol, split, game), {})


def window_mean(steps: list[int], values: list[float], step: int) -> float:
    """Returns the mean of values in the tenth before a step, as the published numbers are."""
    inside = [v for s, v in zip(steps, values, strict=True) if 0.9 * step < s <= step]
    if not inside:
        raise ValueError(f"there are no values in the tenth before step {step}")
    return sum(inside) / len(inside)
