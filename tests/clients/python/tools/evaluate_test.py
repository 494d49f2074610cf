"""procgen-evaluate follows the paper's protocol, with the constants of the catalog."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from procgen_client import Client, ServerProcess, errors
from procgen_client.options import GAMES
from procgen_client.tools import evaluate
from procgen_client.tools.evaluate import GameScore, ProgressLine, Protocol

_FOLDER = Path(__file__).resolve().parent
_SMALL = Protocol(mode="easy", train_levels=3, episode_count=12, env_count=4, rand_seed=5)


def always(action: int) -> evaluate.MakePolicy:
    return lambda game: lambda observations: np.full(len(observations), action)


def right(game: str) -> evaluate.Policy:
    """A policy for the command line that always moves right."""
    return always(7)(game)


def _play_by_hand(client: Client, num_levels: int) -> float:
    """Mean return of three episodes in each of four environments, always moving right."""
    returns: list[list[float]] = [[] for _ in range(4)]
    with client.create_pool(
        "coinrun", 4, distribution_mode="easy", num_levels=num_levels, rand_seed=5
    ) as pool:
        while min(map(len, returns)) < 3:
            batch = pool.step([7] * 4)
            for i in np.flatnonzero(batch.ended):
                returns[i].append(float(batch.episode_returns[i]))
                assert num_levels == 0 or 0 <= batch.prev_level_seeds[i] < num_levels
    return float(np.mean([each[:3] for each in returns]))


def test_scores_average_equally_many_episodes_per_environment(client: Client) -> None:
    (score,) = evaluate.evaluate(client, ["coinrun"], always(7), _SMALL)
    assert score.episode_count == 12
    assert score.train_return == pytest.approx(_play_by_hand(client, 3))
    assert score.test_return == pytest.approx(_play_by_hand(client, 0))
    # Cobbe et al., 2020, appendix C: coinrun's constants in easy mode are 5 and 10.
    assert score.train_score == pytest.approx((score.train_return - 5) / 5)
    assert score.test_score == pytest.approx((score.test_return - 5) / 5)


def test_default_train_levels_are_those_of_the_paper(client: Client) -> None:
    assert evaluate.TRAIN_LEVELS == {"easy": 200, "hard": 500}
    made: list[str] = []

    def make(game: str) -> evaluate.Policy:
        # Records num_levels of the pools that exist while the game is played.
        def act(observations: np.ndarray) -> np.ndarray:
            made.extend(str(pool.spec.options.num_levels) for pool in client.list_pools())
            return np.full(len(observations), -1)

        return act

    for mode in ("easy", "hard"):
        evaluate.evaluate(client, ["maze"], make, Protocol(mode=mode, episode_count=1))
    assert made == ["200", "0", "500", "0"]


def test_every_game_has_normalization_constants_in_both_modes(client: Client) -> None:
    for mode in evaluate.TRAIN_LEVELS:
        for game in GAMES:
            low, high = evaluate.return_range(client.catalog(), game, mode)
            assert low < high


def test_client_lists_the_games_of_the_server(client: Client) -> None:
    assert [game.name for game in client.catalog().games] == list(GAMES)


def test_progress_is_printed(client: Client) -> None:
    output = io.StringIO()
    evaluate.evaluate(client, ["maze"], always(-1), _SMALL, ProgressLine(output, 1))
    assert output.getvalue() == (
        "[1/1] maze, train levels: 12 of 12 episodes\n[1/1] maze, test levels: 12 of 12 episodes\n"
    )

    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    terminal = Terminal()
    evaluate.evaluate(client, ["maze"], always(-1), _SMALL, ProgressLine(terminal, 1))
    assert "\r\033[K[1/1] maze, train levels: 4 of 12 episodes\r" in terminal.getvalue()


def test_table_ends_with_the_mean() -> None:
    scores = [
        GameScore("coinrun", 10, 9.0, 8.0, 0.8, 0.6),
        GameScore("maze", 10, 7.0, 5.0, 0.4, 0.0),
    ]
    assert evaluate.table(scores).splitlines()[2:] == [
        "| coinrun | 9.00 | 8.00 | 0.800 | 0.600 | 0.200 |",
        "| maze | 7.00 | 5.00 | 0.400 | 0.000 | 0.400 |",
        "| mean | | | 0.600 | 0.300 | 0.300 |",
    ]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mode": "memory"}, "mode is 'memory'; it is one of easy, hard"),
        ({"episode_count": 0}, "episode_count is 0"),
        ({"env_count": 0}, "env_count is 0"),
        ({"train_levels": -1}, "train_levels is -1"),
    ],
)
def test_invalid_protocols_are_rejected(
    client: Client, change: dict[str, object], message: str
) -> None:
    with pytest.raises(errors.InvalidArgumentError, match=message):
        evaluate.evaluate(client, ["maze"], always(4), _SMALL._replace(**change))


def _command(*arguments: str) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PYTHONPATH": f"{os.environ.get('PYTHONPATH', '')}:{_FOLDER}"}
    return subprocess.run(
        [sys.executable, "-m", "procgen_client.tools.evaluate", *arguments],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


def test_command_prints_a_table_and_writes_json_and_plot(
    server: ServerProcess, tmp_path: Path
) -> None:
    pytest.importorskip("matplotlib")
    run = _command(
        *("coinrun", "maze", "--server", server.address, "--mode", "easy", "--episodes", "4"),
        *("--environments", "2", "--policy", "evaluate_test:right"),
        *("--json", str(tmp_path / "scores.json"), "--plot", str(tmp_path / "scores.png")),
    )
    assert run.returncode == 0, run.stderr
    assert [line.split(" | ")[0] for line in run.stdout.splitlines()[2:]] == [
        "| coinrun",
        "| maze",
        "| mean",
    ]
    assert "[2/2] maze, test levels: 4 of 4 episodes" in run.stderr
    written = json.loads((tmp_path / "scores.json").read_text())
    assert [game["game"] for game in written["games"]] == ["coinrun", "maze"]
    mean = np.mean([game["test_score"] for game in written["games"]])
    assert written["mean_test_score"] == pytest.approx(mean)
    assert (tmp_path / "scores.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["pong"], "no constants for 'pong'"),
        (["maze", "--policy", "nothing"], "MODULE:FUNCTION"),
        (["maze", "--policy", "no_such_module:make"], "no_such_module"),
        (["maze", "--policy", "json:make"], "'make'"),
        (["maze", "--mode", "memory"], "one of easy, hard"),
    ],
)
def test_command_reports_invalid_arguments(
    server: ServerProcess, arguments: list[str], message: str
) -> None:
    run = _command(*arguments, "--server", server.address)
    assert run.returncode == 2
    assert message in run.stderr
    assert "Traceback" not in run.stderr
