"""Training runs that take seconds, and their comparable results."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("torch")

from learners import ppo, rainbow
from learners.environments import Environments
from learners.options import words_of
from procgen_client import Batch, ServerProcess

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
    return words_of(values)


def train(output: Path, server: str | None = None, **others: Any) -> dict[str, str]:  # noqa: ANN401
    """Trains PPO in this process; returns the results."""
    assert ppo.main(options(output, server, **others)) == 0
    return results(output)


def train_rainbow(
    output: Path, server: str | None = None, **others: Any  # noqa: ANN401
) -> dict[str, str]:
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


class RestartedEnvironments(Environments):
    """Environments that kill and restart their server: three times in rollouts, once after one."""

    server: ServerProcess
    restarts = 0
    received = 0

    @classmethod
    @contextmanager
    def server_to_restart(cls) -> Iterator[str]:
        """Starts the server; yields its address."""
        cls.server, cls.restarts = ServerProcess(), 0
        try:
            yield cls.server.address
        finally:
            cls.server.stop()

    def rollout(
        self, step_count: int | None = None, *, out: Any = None  # noqa: ANN401
    ) -> Iterator[tuple[int, slice, Batch]]:
        """As Environments.rollout, with restarts."""
        for turn in super().rollout(step_count, out=out):
            yield turn
            self.received += 1
            if self.received % 100 == 50 and self.restarts < 3:
                self._restart_server()
        if self.restarts == 3:
            self._restart_server()

    @classmethod
    def _restart_server(cls) -> None:
        cls.restarts += 1
        os.kill(cls.server.process_id, signal.SIGKILL)
        cls.server.stop()
        cls.server = ServerProcess(address=cls.server.address)
