"""PPO runs depend only on their options, not on interruptions, servers, threads or ranks."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from small_runs import STEPS_OF_UPDATE, options, results, train

from learners import ppo
from learners.environments import Environments
from procgen_client import Batch, ServerProcess


@pytest.fixture(scope="module")
def uninterrupted(
    server: ServerProcess, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, str]:
    """The results of four updates."""
    return train(tmp_path_factory.mktemp("uninterrupted"), server.address)


def test_each_update_writes_a_row(uninterrupted: dict[str, str]) -> None:
    header, *rows = uninterrupted["progress"].splitlines()
    assert header == "step,return_mean,length_mean"
    assert [int(row.split(",")[0]) for row in rows] == [256, 512, 768, 1024]
    assert len(uninterrupted["learning"].splitlines()) == 5
    header, *episodes = uninterrupted["episodes"].splitlines()
    assert header == "step,environment,level_seed,return,length"
    assert episodes, "episodes ended"
    for row in episodes:
        step, environment, level_seed, _, length = map(float, row.split(","))
        assert step % 8 == 0 and 0 <= environment < 8 and 0 <= level_seed < 200
        assert 0 < length <= step / 8


def test_equal_seeds_give_equal_runs(
    server: ServerProcess, uninterrupted: dict[str, str], tmp_path: Path
) -> None:
    assert train(tmp_path / "same", server.address, threads=1) == uninterrupted
    other = train(tmp_path / "other", server.address, seed=1)
    assert other["learning"] != uninterrupted["learning"]


def test_steps_given_as_tensors_give_an_equal_run(
    server: ServerProcess,
    uninterrupted: dict[str, str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A CUDA graph cannot be called with an integer."""
    steps = torch.arange(100).split(1)
    monkeypatch.setattr(ppo.Ppo, "choose", lambda self, t, rows: self.act(steps[t], rows).numpy)
    assert train(tmp_path, server.address) == uninterrupted


def test_actions_sent_by_a_thread_give_an_equal_run(
    server: ServerProcess,
    uninterrupted: dict[str, str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A GPU chooses the actions of a half while the other is received."""
    monkeypatch.setattr(ppo.Ppo, "sends_in_background", lambda self: True)
    assert train(tmp_path, server.address) == uninterrupted


def test_checkpoint_can_be_read_with_another_version_of_numpy(
    server: ServerProcess, tmp_path: Path
) -> None:
    train(tmp_path, server.address, time_limit=0)
    with zipfile.ZipFile(tmp_path / "checkpoint.pt") as archive:
        (name,) = (name for name in archive.namelist() if name.endswith("/data.pkl"))
        assert b"numpy" not in archive.read(name)


def test_run_stopped_after_each_update_equals_an_uninterrupted_run(
    server: ServerProcess, uninterrupted: dict[str, str], tmp_path: Path
) -> None:
    for update in range(1, 5):
        stopped = train(tmp_path, server.address, time_limit=0, resume=True)
        assert len(stopped["learning"].splitlines()) == 1 + update
    assert stopped == uninterrupted


def test_rows_after_the_checkpoint_are_rewritten(
    server: ServerProcess, uninterrupted: dict[str, str], tmp_path: Path
) -> None:
    train(tmp_path, server.address, time_limit=0)
    for name in ("progress", "episodes", "learning"):
        with open(tmp_path / f"{name}.csv", "a") as file:
            file.write("what a killed run has left")
    (tmp_path / "checkpoint.part").write_bytes(b"an unfinished checkpoint")
    assert train(tmp_path, server.address, resume=True) == uninterrupted


def test_sigterm_saves_the_run(
    server: ServerProcess, uninterrupted: dict[str, str], tmp_path: Path
) -> None:
    command = options(tmp_path, server.address, total_steps=100 * STEPS_OF_UPDATE)
    process = subprocess.Popen([sys.executable, "-m", "learners.ppo", *command])
    while process.poll() is None:
        progress = tmp_path / "progress.csv"
        if progress.exists() and len(progress.read_text().splitlines()) == 3:
            process.send_signal(signal.SIGTERM)
            process.wait()
    assert process.returncode == 128 + signal.SIGTERM
    saved = results(tmp_path)["learning"].splitlines()
    assert uninterrupted["learning"].splitlines()[:3] == saved[:3]
    assert len(saved) < 100


def test_checkpoint_is_neither_overwritten_nor_resumed_with_other_options(
    server: ServerProcess, tmp_path: Path
) -> None:
    train(tmp_path, server.address, total_steps=STEPS_OF_UPDATE)
    with pytest.raises(SystemExit, match="--resume continues from it"):
        train(tmp_path, server.address)
    with pytest.raises(SystemExit, match="was begun with seed 0, not 1"):
        train(tmp_path, server.address, resume=True, seed=1)


class _RestartedEnvironments(Environments):
    """Environments that kill and restart their server in the middle of a rollout."""

    server: ServerProcess
    received = 0
    restarts = 0

    def rollout(
        self, step_count: int, out: Any  # noqa: ANN401
    ) -> Iterator[tuple[int, slice, Batch]]:
        for turn in super().rollout(step_count, out):
            yield turn
            self.received += 1
            if self.received % 100 == 50 and self.restarts < 3:
                self.restarts += 1
                os.kill(self.server.process_id, signal.SIGKILL)
                self.server.stop()
                type(self).server = ServerProcess(address=self.server.address)


@pytest.mark.parametrize("background", [False, True])
def test_training_survives_server_restarts(
    uninterrupted: dict[str, str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    background: bool,  # noqa: FBT001 - a parameter of the test
) -> None:
    monkeypatch.setattr(ppo.Ppo, "sends_in_background", lambda self: background)
    made: list[_RestartedEnvironments] = []

    def make(*arguments: Any, **keywords: Any) -> _RestartedEnvironments:  # noqa: ANN401
        made.append(_RestartedEnvironments(*arguments, **keywords))
        return made[-1]

    _RestartedEnvironments.server = ServerProcess()
    try:
        address = _RestartedEnvironments.server.address
        assert ppo.train(ppo.parse(options(tmp_path, address)), make) == 0
    finally:
        _RestartedEnvironments.server.stop()
    assert made[0].restarts == 3
    assert results(tmp_path) == uninterrupted


def _train_on_two_ranks(output: Path, servers: str) -> dict[str, str]:
    """Starts two ranks as torchrun does. Debian's torchrun does not work with Python 3.11."""
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        place = {"MASTER_ADDR": "127.0.0.1", "MASTER_PORT": str(unused.getsockname()[1])}
    words = options(output, servers, total_steps=2 * 2 * STEPS_OF_UPDATE)
    ranks = [
        subprocess.Popen(
            [sys.executable, "-m", "learners.ppo", *words],
            env=os.environ | place | {"RANK": str(rank), "WORLD_SIZE": "2"},
        )
        for rank in range(2)
    ]
    assert [rank.wait() for rank in ranks] == [0, 0]
    return results(output)


def test_two_ranks_on_one_or_two_servers_give_equal_runs(
    server: ServerProcess, tmp_path: Path
) -> None:
    one = _train_on_two_ranks(tmp_path / "one", server.address)
    with ServerProcess() as other:
        two = _train_on_two_ranks(tmp_path / "two", f"{server.address},{other.address}")
    assert one == two
    environments = {int(row.split(",")[1]) for row in one["episodes"].splitlines()[1:]}
    assert min(environments) < 8 <= max(environments) < 16


def test_advantages_are_generalized_advantage_estimates() -> None:
    rewards, ended = np.float32([[1], [0], [2]]), np.array([[False], [True], [False]])
    values = np.float32([[0.5], [0.25], [1], [4]])
    advantages = ppo.estimate_advantages(rewards, ended, values, gamma=0.9, lambda_=0.8)
    last = 2 + 0.9 * 4 - 1
    second = 0 - 0.25
    first = 1 + 0.9 * 0.25 - 0.5 + 0.9 * 0.8 * second
    assert advantages.ravel() == pytest.approx([first, second, last])
