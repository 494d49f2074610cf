"""procgen-dataset records, expands and continues after it was killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from procgen_client.dataset import load
from procgen_client.dataset.cli import main

_SMALL = ("--mode", "easy", "--levels", "20", "--workers", "2")


def _program(*arguments: str | Path | int) -> list[str]:
    return [sys.executable, "-m", "procgen_client.dataset", *map(str, arguments)]


def _run(*arguments: str | Path | int) -> subprocess.CompletedProcess[str]:
    return subprocess.run(_program(*arguments), capture_output=True, text=True, check=False)


def _contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes()
            for path in sorted(folder.rglob("*")) if path.is_file()}  # fmt: skip


def test_recording_is_expanded_and_described(tmp_path: Path) -> None:
    data, frames = tmp_path / "data", tmp_path / "frames"
    run = _run(
        *("record", "bigfish", "maze", "--steps", 5000, "--output", data, *_SMALL),
        *("--option", "use_backgrounds=false", "--policy", "sticky:0.5", "--seed", 3),
    )
    assert run.returncode == 0, run.stderr
    assert run.stderr.startswith("recorded 16,384 of 16,384 steps, ")
    assert run.stderr.count("\n") == 1
    header = load(data / "maze-00000-of-00001.trajectories.npz").header
    assert header.options == {"distribution_mode": "easy", "num_levels": 20, "rand_seed": 3,
                              "use_backgrounds": False}  # fmt: skip
    assert _run("replay", data, "--verify").returncode == 0
    run = _run("replay", data, "--format", "npz", "--output", frames, "--screen-size", "32")
    assert run.returncode == 0, run.stderr
    with np.load(frames / "maze-00000-of-00001-000000.npz") as archive:
        assert archive["observations"].shape == (64, 64, 32, 32, 3)
    lines = _run("info", data).stdout.splitlines()
    assert len(lines) == 4
    assert "bigfish-00000-of-00001.trajectories.npz | 8,192 | 64 | " in lines[2]
    assert lines[2].endswith("| 20 | sticky:0.5 |")


def test_workers_change_nothing(tmp_path: Path) -> None:
    for workers in ("1", "3"):
        arguments = ["record", "bigfish", "--steps", "10000", "--environments", "150",
                     "--output", str(tmp_path / workers), "--workers", workers]  # fmt: skip
        assert main(arguments) == 0
    assert len(_contents(tmp_path / "1")) == 3
    assert _contents(tmp_path / "1") == _contents(tmp_path / "3")


def test_frames_of_record_are_those_of_replay(tmp_path: Path) -> None:
    for name in ("one", "two"):
        arguments = ["record", "maze", "--steps", "4096", *_SMALL, "--output", tmp_path / name]
        if name == "one":
            arguments += ["--format", "webdataset", "--frames", tmp_path / "frames-one"]
        assert main(list(map(str, arguments))) == 0
    assert main(["replay", str(tmp_path / "two"), "--format", "webdataset",
                 "--output", str(tmp_path / "frames-two")]) == 0  # fmt: skip
    for name in ("", "frames-"):
        assert _contents(tmp_path / f"{name}one") == _contents(tmp_path / f"{name}two")
    assert len(_contents(tmp_path / "frames-one")) == 2


def test_killed_program_is_continued(tmp_path: Path) -> None:
    """Kills it again and again, each time a little later, until it is done."""
    record = ("record", "bigfish", "--steps", "8000", "--environments", "130", *_SMALL,
              "--format", "npz", "--segment-length", "16")  # fmt: skip
    whole = ("--output", tmp_path / "a/data", "--frames", tmp_path / "a/frames")
    assert _run(*record, *whole).returncode == 0
    command = _program(*record, "--output", tmp_path / "b/data", "--frames", tmp_path / "b/frames")
    kills = 0
    while True:
        # A group of its own, which ends with the program.
        with subprocess.Popen(command, stderr=subprocess.DEVNULL) as program:
            known = len(_contents(tmp_path / "b"))
            while program.poll() is None and len(_contents_now(tmp_path / "b")) < known + 3:
                time.sleep(0.001)
            if program.poll() is None:
                program.send_signal(signal.SIGKILL)
                kills += 1
        if program.returncode == 0:
            break
        assert program.returncode == -signal.SIGKILL
    assert kills >= 3
    # Writing of a killed process may have left parts; the last run has written the files again.
    assert _contents(tmp_path / "a") == {
        name: data for name, data in _contents(tmp_path / "b").items() if name[-5:] != ".part"
    }


def _contents_now(folder: Path) -> list[str]:
    """Names of the files of a folder that another process changes."""
    return [name for _, _, names in os.walk(folder) for name in names if name[-5:] != ".part"]


def test_interrupted_program_says_how_to_continue(tmp_path: Path) -> None:
    arguments = ("record", "maze", "--steps", "100000000", "--output", tmp_path, "--workers", "2")
    with subprocess.Popen(_program(*arguments), stderr=subprocess.PIPE, text=True,
                          start_new_session=True) as program:  # fmt: skip
        while not _contents_now(tmp_path):
            assert program.poll() is None
            time.sleep(0.01)
        os.killpg(program.pid, signal.SIGINT)  # As a terminal does.
        _, said = program.communicate()
    assert program.returncode == 130
    assert said == "\nprocgen-dataset: interrupted; repeat the command to continue\n"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["replay", "x", "--verify"], "NOT_FOUND: x does not exist"),
        (["replay", "x"], "give either --verify or --format"),
        (["replay", "x", "--verify", "--format", "npz"], "give either --verify or --format"),
        (["replay", "x", "--format", "npz"], "--format needs a folder"),
        (["replay", "x", "--verify", "--screen-size", "32"], "--screen-size needs --format"),
        (["replay", "x", "--verify", "--workers", "0"], "workers is 0; it is at least 1"),
        (["record", "pong", "--steps", "9", "--output", "x"], "NOT_FOUND: no game is named"),
        (["record", "maze", "--steps", "9", "--output", "x", "--option", "rand_seed=1"], "--seed"),
        (["record", "maze", "--steps", "9", "--output", "x", "--option", "sticky=1"], "no option"),
        (["record", "maze", "--steps", "9", "--output", "x", "--art", "/none"], "/none"),
        (["record", "maze", "--steps", "-9", "--output", "x"], "steps is -9; it is in [1,"),
        (["record", "maze", "--steps", "9", "--output", "x", "--mode", "no"], "is one of easy"),
    ],
)
def test_wrong_arguments_are_errors(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    said = capsys.readouterr().err
    assert said.startswith("procgen-dataset: ")
    assert message in said
    assert not list(tmp_path.iterdir())
