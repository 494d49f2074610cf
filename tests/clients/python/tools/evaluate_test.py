"""The program procgen-evaluate."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from procgen_client import ServerProcess
from procgen_client.tools.evaluation import Protocol
from procgen_client.tools.play_episodes import Policy

_FOLDER = Path(__file__).resolve().parent
_SMALL = Protocol(mode="easy", train_levels=3, episode_count=12, env_count=4, rand_seed=5)


def right(game: str) -> Policy:
    """A policy for the command line that always moves right."""
    return lambda observations: np.full(len(observations), 7)


def ends(game: str) -> Policy:
    """A policy that ends each episode."""
    return lambda observations: np.full(len(observations), -1)


def recurrent(game: str) -> Policy:
    """A recurrent policy that ends each episode after two steps, of stacked observations."""
    steps = np.zeros(2, int)

    def act(observations: np.ndarray, first: np.ndarray) -> np.ndarray:
        assert observations.shape == (2, 3, 64, 64, 1)
        steps[:] = np.where(first, 1, steps + 1)
        return np.where(steps == 2, -1, 4)

    return act


def _command(*arguments: str) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PYTHONPATH": f"{os.environ.get('PYTHONPATH', '')}:{_FOLDER}"}
    return subprocess.run(
        [sys.executable, "-m", "procgen_client.tools.evaluate", *arguments],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


def test_command_prints_a_table_and_writes_every_episode(
    server: ServerProcess, tmp_path: Path
) -> None:
    run = _command(
        *("bigfish", "starpilot", "--server", server.address, "--mode", "easy"),
        *("--episodes", "4", "--environments", "2", "--policy", "evaluate_test:right"),
        *("--json", str(tmp_path / "scores.json")),
    )
    assert run.returncode == 0, run.stderr
    lines = run.stdout.splitlines()
    assert lines[0] == "easy mode; training levels are 0 ... 199"
    assert [line.split(" | ")[0] for line in lines[4:]] == [
        "| bigfish",
        "| starpilot",
        "| mean",
        "| interquartile mean",
    ]
    assert "starpilot, test levels: 4 of 4 episodes, " in run.stderr
    written = json.loads((tmp_path / "scores.json").read_text())
    assert written["policy"] == "evaluate_test:right"
    assert written["protocol"]["train_levels"] == 200
    assert [game["game"] for game in written["games"]] == ["bigfish", "starpilot"]
    assert len(written["episodes"]) == 2 * 2 * 4
    for game in written["games"]:
        low, high = game["return_range"]
        for levels in ("train", "test"):
            returns = [
                episode["return"]
                for episode in written["episodes"]
                if (episode["game"], episode["levels"]) == (game["game"], levels)
            ]
            assert game[levels]["return_mean"] == pytest.approx(np.mean(returns))
            assert game[levels]["score"] == pytest.approx((np.mean(returns) - low) / (high - low))
    mean = np.mean([game["test"]["score"] for game in written["games"]])
    assert written["test"]["mean"] == pytest.approx(mean)


def test_recurrent_policy_plays_with_options(server: ServerProcess, tmp_path: Path) -> None:
    run = _command(
        *("bigfish", "--server", server.address, "--mode", "easy", "--episodes", "6"),
        *("--environments", "2", "--policy", "evaluate_test:recurrent"),
        *("--option", "frame_stack=3", "--option", "grayscale_obs=true"),
        *("--json", str(tmp_path / "scores.json")),
    )
    assert run.returncode == 0, run.stderr
    written = json.loads((tmp_path / "scores.json").read_text())
    assert written["protocol"]["options"] == {"frame_stack": 3, "grayscale_obs": True}
    assert {episode["length"] for episode in written["episodes"]} == {2}


def test_plot_is_drawn(server: ServerProcess, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    run = _command(
        *("bigfish", "maze", "--server", server.address, "--mode", "easy", "--episodes", "4"),
        *("--environments", "2", "--policy", "evaluate_test:ends"),
        *("--plot", str(tmp_path / "scores.png")),
    )
    assert run.returncode == 0, run.stderr
    assert (tmp_path / "scores.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["pong"], "no constants for 'pong'"),
        (["maze", "--policy", "nothing"], "MODULE:FUNCTION"),
        (["maze", "--policy", "no_such_module:make"], "no_such_module"),
        (["maze", "--policy", "json:make"], "'make'"),
        (["maze", "--mode", "memory"], "one of easy, hard"),
        (["maze", "--option", "num_levels=3"], "it is one of screen_size"),
        (["maze", "--option", "layout=whc"], "layout is 'whc'"),
    ],
)
def test_command_reports_invalid_arguments(
    server: ServerProcess, arguments: list[str], message: str
) -> None:
    run = _command(*arguments, "--server", server.address)
    assert run.returncode == 2
    assert message in run.stderr
    assert "Traceback" not in run.stderr
