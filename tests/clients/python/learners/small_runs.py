"""Training runs that take seconds, and their comparable results."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("torch")

from learners import ppo, rainbow

# Columns of progress.csv that do not depend on the time.
_TIMELESS_COLUMNS = 3
STEPS_OF_UPDATE = 8 * 32


def options(output: Path, server: str | None, **others: Any) -> list[str]:  # noqa: ANN401
    """Returns the arguments of a run with 256 steps per update. True: a flag; None: omitted."""
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
        if value is None:
            continue
        words += [f"--{name.replace('_', '-')}"] + ([] if value is True else [str(value)])
    return words


def train(output: Path, server: str, **others: Any) -> dict[str, str]:  # noqa: ANN401
    """Trains PPO in this process; returns the results."""
    assert ppo.main(options(output, server, **others)) == 0
    return results(output)


def train_rainbow(output: Path, server: str, **others: Any) -> dict[str, str]:  # noqa: ANN401
    """Trains Rainbow in this process with a replay of half the steps; returns the results."""
    small = {"minibatches": None, "chunk_size": 8, "batch_size": 16}
    small |= {"replay_size": 512, "learning_starts": 64, "target_interval": 160}
    assert rainbow.main(options(output, server, **(small | others))) == 0
    return results(output)


def results(output: Path) -> dict[str, str]:
    """Returns the contents of a run's files, without columns that depend on the time."""
    progress = (output / "progress.csv").read_text().splitlines()
    return {
        "episodes": (output / "episodes.csv").read_text(),
        "learning": (output / "learning.csv").read_text(),
        "progress": "\n".join(
            ",".join(line.split(",")[:_TIMELESS_COLUMNS]) for line in progress
        ),
    }
