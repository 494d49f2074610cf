"""PPO runs depend only on their options, not on interruptions, servers, threads or ranks."""

from __future__ import annotations

import signal
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from small_runs import STEPS_OF_UPDATE, RestartedEnvironments, options, results, train

from learners import ppo
from learners.rollouts import Collector, estimate_advantages
from procgen_client import ServerProcess


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


def test_equal_seeds_give_equal_runs_in_process_and_on_a_server(
    server: ServerProcess, uninterrupted: dict[str, str], tmp_path: Path
) -> None:
    assert train(tmp_path / "same", server.address, threads=1) == uninterrupted
    other = train(tmp_path / "other", seed=1)
    assert other["learning"] != uninterrupted["learning"]


def test_steps_given_as_tensors_give_an_equal_run(
    server: ServerProcess,
    uninterrupted: dict[str, str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A CUDA graph cannot be called with an integer."""
    expected = train(tmp_path / "lstm", lstm=True, total_steps=2 * STEPS_OF_UPDATE)
    steps, act = torch.arange(100).split(1), Collector.act
    monkeypatch.setattr(Collector, "act", lambda self, t, rows: act(self, steps[t], rows))
    assert train(tmp_path / "plain") == uninterrupted
    found = train(tmp_path / "lstm_too", lstm=True, total_steps=2 * STEPS_OF_UPDATE)
    assert found == expected


def test_actions_sent_by_a_thread_give_an_equal_run(
    server: ServerProcess,
    uninterrupted: dict[str, str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A GPU chooses the actions of a half while the other is received."""
    monkeypatch.setattr(Collector, "sends_in_background", lambda self: True)
    assert train(tmp_path) == uninterrupted


def test_checkpoint_can_be_read_with_another_version_of_numpy(
    server: ServerProcess, tmp_path: Path
) -> None:
    train(tmp_path, time_limit=0)
    with zipfile.ZipFile(tmp_path / "checkpoint.pt") as archive:
        (name,) = (name for name in archive.namelist() if name.endswith("/data.pkl"))
        assert b"numpy" not in archive.read(name)


def test_run_stopped_after_each_update_equals_an_uninterrupted_run(
    server: ServerProcess, uninterrupted: dict[str, str], tmp_path: Path
) -> None:
    for update in range(1, 5):
        stopped = train(tmp_path, time_limit=0, resume=True)
        assert len(stopped["learning"].splitlines()) == 1 + update
    assert stopped == uninterrupted


def test_rows_after_the_checkpoint_are_rewritten(
    server: ServerProcess, uninterrupted: dict[str, str], tmp_path: Path
) -> None:
    train(tmp_path, time_limit=0)
    for name in ("progress", "episodes", "learning"):
        with open(tmp_path / f"{name}.csv", "a") as file:
            file.write("what a killed run has left")
    (tmp_path / "checkpoint.part").write_bytes(b"an unfinished checkpoint")
    assert train(tmp_path, resume=True) == uninterrupted


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
    train(tmp_path, total_steps=STEPS_OF_UPDATE)
    with pytest.raises(SystemExit, match="--resume continues from it"):
        train(tmp_path)
    with pytest.raises(SystemExit, match="was begun with seed 0, not 1"):
        train(tmp_path, resume=True, seed=1)


@pytest.mark.parametrize("background", [False, True])
def test_training_survives_server_restarts(
    uninterrupted: dict[str, str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    background: bool,  # noqa: FBT001 - a parameter of the test
) -> None:
    monkeypatch.setattr(Collector, "sends_in_background", lambda self: background)
    monkeypatch.setattr(ppo, "Environments", RestartedEnvironments)
    with RestartedEnvironments.server_to_restart() as address:
        assert ppo.main(options(tmp_path, address)) == 0
    assert RestartedEnvironments.restarts == 4
    assert results(tmp_path) == uninterrupted


def _train_on_two_ranks(
    output: Path, servers: str, **others: Any  # noqa: ANN401
) -> dict[str, str]:
    # Not --standalone, which takes port 29400 in PyTorch 1.13, so that two runs exclude each other.
    torchrun = ["torch.distributed.run", "--nproc_per_node", "2"]
    torchrun += ["--rdzv_backend", "c10d", "--rdzv_endpoint", "localhost:0"]
    # PyTorch 1.13 needs -r and -t with Python 3.11.
    torchrun += ["-r", "1", "-t", "2", "--log_dir", str(output / "log")]
    words = options(output, servers, total_steps=2 * 2 * STEPS_OF_UPDATE, **others)
    subprocess.run(
        [sys.executable, "-m", *torchrun, "-m", "learners.ppo", *words], check=True
    )
    return results(output)


def test_two_ranks_stopped_and_continued_on_two_servers_give_an_equal_run(
    server: ServerProcess, tmp_path: Path
) -> None:
    one = _train_on_two_ranks(tmp_path / "one", server.address)
    with ServerProcess() as other:
        for update, servers in enumerate((server.address, f"{server.address},{other.address}"), 1):
            stopped = _train_on_two_ranks(
                tmp_path / "stopped", servers, time_limit=0, resume=True
            )
            assert len(stopped["learning"].splitlines()) == 1 + update
    assert stopped == one
    environments = {int(row.split(",")[1]) for row in one["episodes"].splitlines()[1:]}
    assert min(environments) < 8 <= max(environments) < 16


def test_advantages_are_generalized_advantage_estimates() -> None:
    rewards, ended = torch.tensor([[1.0], [0], [2]]), torch.tensor([[0.0], [1], [0]])
    values = torch.tensor([[0.5], [0.25], [1], [4]])
    advantages = estimate_advantages(rewards, ended, values, gamma=0.9, lambda_=0.8)
    last = 2 + 0.9 * 4 - 1
    second = 0 - 0.25
    first = 1 + 0.9 * 0.25 - 0.5 + 0.9 * 0.8 * second
    assert advantages.ravel().tolist() == pytest.approx([first, second, last])


def test_advantages_equal_those_of_float64() -> None:
    """Over a whole rollout, with episodes that end."""
    torch.manual_seed(0)
    rewards, values = torch.randn(256, 64), torch.randn(257, 64)
    ended = (torch.rand(256, 64) < 0.02).float()
    found = estimate_advantages(rewards, ended, values, gamma=0.999, lambda_=0.95)
    expected, following = np.zeros((256, 64)), np.zeros(64)
    x, v, alive = rewards.double().numpy(), values.double().numpy(), 1 - ended.double().numpy()
    for t in reversed(range(256)):
        delta = x[t] + 0.999 * v[t + 1] * alive[t] - v[t]
        expected[t] = following = delta + 0.999 * 0.95 * alive[t] * following
    np.testing.assert_allclose(found.numpy(), expected, rtol=1e-4, atol=1e-5)
