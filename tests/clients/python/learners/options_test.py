"""A run's options and versions are written, and can be given as a file."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from small_runs import STEPS_OF_UPDATE, train

from learners import ppo

torch = pytest.importorskip("torch")


def test_run_is_repeated_from_its_description(tmp_path: Path) -> None:
    expected = train(tmp_path / "one", total_steps=STEPS_OF_UPDATE, learning_rate=1e-3)
    text = (tmp_path / "one/run.json").read_text()
    described = json.loads(text, parse_constant=pytest.fail)  # JSON has no Infinity.
    assert described["versions"]["torch"] == torch.__version__
    assert described["options"]["learning_rate"] == 1e-3
    words = ["--config", str(tmp_path / "one/run.json"), "--output", str(tmp_path / "two")]
    assert ppo.main(words) == 0
    assert (tmp_path / "two/learning.csv").read_text() == expected["learning"]


def test_arguments_override_a_configuration(tmp_path: Path) -> None:
    path = tmp_path / "config.json"
    path.write_text('{"learning_rate": 0.25, "compile": false, "lstm": true, "levels": 0}')
    options = ppo.parse(["--config", str(path), "--learning-rate", "0.5"])
    assert (options.learning_rate, options.compile, options.lstm) == (0.5, False, True)
    assert options.levels == 0


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ('{"speed": 3}', "unrecognized arguments: --speed"),
        ('{"network": "resnet"}', "invalid choice: 'resnet'"),
        ("[1]", "is not a JSON object of options"),
        ("{", "is not a JSON object of options"),
    ],
)
def test_wrong_configuration_is_rejected(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, problem: str
) -> None:
    path = tmp_path / "config.json"
    path.write_text(text)
    with pytest.raises(SystemExit, match="2"):
        ppo.parse(["--config", str(path)])
    assert problem in capsys.readouterr().err


def test_progress_is_logged_to_weights_and_biases(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("wandb")
    monkeypatch.setenv("WANDB_MODE", "offline")
    train(tmp_path, total_steps=STEPS_OF_UPDATE, wandb="tests")
    (log,) = tmp_path.glob("wandb/offline-run-*/*.wandb")
    assert b"explained_variance" in log.read_bytes()
