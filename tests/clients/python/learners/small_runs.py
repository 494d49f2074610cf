"""Training runs of seconds, and what of their results must be equal."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("torch")

from learners import ppo

# Columns of progress.csv that do not depend on time.
_TIMELESS_COLUMNS = 3
STEPS_OF_UPDATE = 8 * 32


def options(output: Path, server: str, **others: Any) -> list[str]:  # noqa: ANN401
    """A command line of a run whose updates are 256 steps; an option that is True is a flag."""
    values = {
        "game": "bigfish",
        "network": "nature",
        "num_envs": 8,
        "num_steps": 32,
        "minibatches": 2,
        "chunk_size": 64,
        "total_steps": 4 * STEPS_OF_UPDATE,
        "output": output,
        "server": server,
    } | others
    words: list[str] = []
    for name, value in values.items():
        words += [f"--{name.replace('_', '-')}"] + ([] if value is True else [str(value)])
    return words


def train(output: Path, server: str, **others: Any) -> dict[str, str]:  # noqa: ANN401
    """Trains in this process; returns the results."""
    assert ppo.main(options(output, server, **others)) == 0
    return results(output)


def results(output: Path) -> dict[str, str]:
    """Returns what must be equal for equal runs: the files' texts, without columns of time."""
    progress = (output / "progress.csv").read_text().splitlines()
    return {
        "episodes": (output / "episodes.csv").read_text(),
        "learning": (output / "learning.csv").read_text(),
        "progress": "\n".join(
            ",".join(line.split(",")[:_TIMELESS_COLUMNS]) for line in progress
        ),
    }
