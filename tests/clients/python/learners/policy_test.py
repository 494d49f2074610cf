"""procgen-evaluate plays policies that the learners saved."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from small_runs import STEPS_OF_UPDATE, train, train_rainbow

from learners import policy
from procgen_client import ServerProcess, errors
from procgen_client.dataset import load, replay


@pytest.fixture(scope="module")
def runs(server: ServerProcess, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a run of PPO on bigfish and one of Rainbow on coinrun."""
    folder = tmp_path_factory.mktemp("runs")
    train(folder / "bigfish", total_steps=STEPS_OF_UPDATE)
    train_rainbow(folder / "coinrun", game="coinrun", total_steps=STEPS_OF_UPDATE)
    return folder


def test_evaluation_plays_saved_policies(server: ServerProcess, runs: Path) -> None:
    run = subprocess.run(
        [
            *(sys.executable, "-W", "error::UserWarning", "-m", "procgen_client.tools.evaluate"),
            *("bigfish", "coinrun"),  # PyTorch would warn of read-only observations.
            *("--mode", "easy", "--policy", "learners.policy:load", "--server", server.address),
            *("--episodes", "4", "--environments", "4"),
        ],
        env=os.environ | {"PROCGEN_RUN": str(runs)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    assert [line.split(" | ")[0] for line in run.stdout.splitlines()[4:]] == [
        "| bigfish",
        "| coinrun",
        "| mean",
        "| interquartile mean",
    ]


@pytest.mark.parametrize("game", ["bigfish", "coinrun"])
def test_equal_calls_give_equal_actions(runs: Path, game: str) -> None:
    observations = np.random.default_rng(0).integers(0, 256, (6, 64, 64, 3), np.uint8)
    actions = [policy.load_run(runs / game)(observations) for _ in range(2)]
    assert (actions[0] == actions[1]).all()
    assert actions[0].shape == (6,)
    assert ((actions[0] >= 0) & (actions[0] < 15)).all()


def test_parts_of_a_data_set_are_sampled_with_different_seeds(runs: Path, tmp_path: Path) -> None:
    subprocess.run(
        [
            *(sys.executable, "-m", "procgen_client.dataset", "record", "bigfish"),
            *("--policy", "learners.policy:load", "--mode", "easy", "--levels", "1"),
            *("--steps", "8192", "--environments", "128", "--output", str(tmp_path)),
        ],
        env=os.environ | {"PROCGEN_RUN": str(runs)},
        capture_output=True,
        check=True,
    )
    one, other = (load(path) for path in sorted(tmp_path.iterdir()))
    assert one.header.policy == "learners.policy:load"
    # The first frames are equal, so with equal seeds the first actions would be, too.
    assert one.frame_digests[0] == other.frame_digests[0]
    assert (one.actions[:, 0] != other.actions[:, 0]).any()
    replay(one, "one")


def test_run_of_another_game_is_rejected(runs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PROCGEN_RUN", str(runs / "bigfish"))
    with pytest.raises(errors.InvalidArgumentError, match="trained on bigfish, not on maze"):
        policy.load("maze")


def test_folder_without_a_run_is_rejected(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PROCGEN_RUN", str(tmp_path))
    with pytest.raises(errors.InvalidArgumentError, match="checkpoint.pt"):
        policy.load("maze")
