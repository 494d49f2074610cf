"""Results of the runs that OpenAI published, to compare with.

results/openai_ppo.csv: the PPO runs of openai/train-procgen (MIT licence; Procgen 0.9.2, upstream's
art, IMPALA, 64 environments). Per protocol, split, game and step: mean and standard deviation over
three runs of the mean in the tenth before that step.

    python3 -m learners.published runs/bigfish

compares runs of PPO with them: at each step of the file, the means over the runs, and in
parentheses their distance from OpenAI's mean, in standard deviations of OpenAI's runs. Three runs
measure a deviation roughly: of single runs of an equal learner, 23 % are more than two away and 5 %
more than five (t distribution with two degrees of freedom).
"""

from __future__ import annotations

import argparse
import csv
import functools
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

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


def read_run(folder: Path) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Returns the options of a run of PPO, and its values by COLUMNS and "step"   [updates]."""
    options = json.loads((folder / "run.json").read_text())["options"]
    values: dict[str, np.ndarray] = {}
    for name in ("progress", "learning"):
        with open(folder / f"{name}.csv", newline="") as file:
            header, *rows = csv.reader(file)
        cells = np.array([[float(cell or "nan") for cell in row] for row in rows])
        values |= dict(zip(header, cells.reshape(-1, len(header)).T, strict=True))
    shown = {name: name for name in ("step", *COLUMNS)}
    shown |= {"return": "return_mean", "length": "length_mean"}
    count = min(map(len, values.values()))  # A run that is running has just written one of them.
    return options, {name: values[column][:count] for name, column in shown.items()}


def window_mean(steps: np.ndarray, values: np.ndarray, step: int) -> float:
    """Returns the mean of values in the tenth before a step; NaN: there are none."""
    inside = values[(0.9 * step < steps) & (steps <= step) & ~np.isnan(values)]
    return float(inside.mean()) if inside.size else float("nan")


def distances(folders: Sequence[Path]) -> dict[int, dict[str, tuple[float, float]]]:
    """Compares runs of equal options but the seed with the published runs.

    Returns:
        By step, by COLUMNS: the mean over the runs, and its distance from the published mean in
        standard deviations.
    """
    read = [read_run(folder) for folder in folders]
    options = read[0][0]
    rows = by_step(options["game"], options["mode"], options["levels"], "train")
    last = min(values["step"][-1] if values["step"].size else 0 for _, values in read)
    compared = {}
    for step in (step for step in rows if step <= 1.02 * last):
        means = {
            name: float(np.mean([window_mean(v["step"], v[name], step) for _, v in read]))
            for name in COLUMNS
        }
        compared[step] = {
            name: (mean, (mean - rows[step][name].mean) / rows[step][name].deviation)
            for name, mean in means.items()
        }
    return compared


def table(runs: Mapping[str, Sequence[Path]]) -> str:
    """Returns the comparison of runs, by their labels, as a Markdown table."""
    lines = [f"| run | seeds | step | {' | '.join(COLUMNS)} |"]
    lines.append(f"| --- |{' ---: |' * (2 + len(COLUMNS))}")
    for label, folders in runs.items():
        for step, columns in (distances(folders) if folders else {}).items():
            cells = (f"{mean:.4g} ({distance:+.1f})" for mean, distance in columns.values())
            lines.append(f"| {label} | {len(folders)} | {step:,} | {' | '.join(cells)} |")
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line; returns the exit status."""
    parser = argparse.ArgumentParser(
        prog="python3 -m learners.published",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("runs", nargs="+", type=Path, metavar="DIR", help="differ in their seeds")
    runs: list[Path] = parser.parse_args(arguments).runs
    print(table({runs[0].name: runs}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
