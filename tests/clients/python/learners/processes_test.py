"""Programs run side by side with their parts of the cores; a signal stops all."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from pathlib import Path

import pytest

pytest.importorskip("torch")

from learners.processes import Processes, Program

# Waits until each of two programs has written its file.
_MEET = """
import os, pathlib, sys, time
folder, mine, other = pathlib.Path(sys.argv[1]), *sys.argv[2:4]
(folder / mine).write_text(",".join(map(str, sorted(os.sched_getaffinity(0)))))
end = time.monotonic() + 60
while not (folder / other).exists():
    assert time.monotonic() < end
    time.sleep(0.01)
print("met", other)
"""
# Writes its file, and the number of a signal that ends it.
_WAIT = """
import pathlib, signal, sys, time
path = pathlib.Path(sys.argv[1])
def stop(number, frame):
    path.write_text(str(number))
    sys.exit(3)
signal.signal(signal.SIGTERM, stop)
signal.signal(signal.SIGINT, stop)
path.write_text("runs")
time.sleep(60)
"""


def _program(label: str, code: str, *arguments: object, ended: list[str] | None = None) -> Program:
    words = [sys.executable, "-c", code, *map(str, arguments)]
    return Program(label, words, lambda: None if ended is None else ended.append(label))


def test_programs_run_at_the_same_time_on_parts_of_the_cores(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    ended: list[str] = []
    one = _program("first", _MEET, tmp_path, "a", "b", ended=ended)
    two = _program("second", _MEET, tmp_path, "b", "a", ended=ended)
    assert Processes(2).run([one, two]) == 0
    assert sorted(ended) == ["first", "second"]
    lines = capfd.readouterr().out.splitlines()
    assert {"first: met b", "second: met a"} <= set(lines)
    mine, its = (set((tmp_path / name).read_text().split(",")) for name in "ab")
    cores = {str(core) for core in os.sched_getaffinity(0)}
    assert mine | its == cores
    assert not mine & its or len(cores) == 1


@pytest.mark.parametrize("count", [1, 2])
def test_failure_is_returned_after_the_other_programs(
    count: int, capfd: pytest.CaptureFixture[str]
) -> None:
    ended: list[str] = []
    programs = [_program("fails", "exit(7)"), _program("later", "", ended=ended)]
    assert Processes(count).run(programs) == 7
    assert ended == ["later"]
    assert "fails ended with status 7\n" in capfd.readouterr().out


@pytest.mark.parametrize("count", [1, 2])
def test_signal_is_passed_on_to_all_programs(tmp_path: Path, count: int) -> None:
    paths = [tmp_path / str(i) for i in range(count + 1)]

    def interrupt() -> None:
        while not all(path.exists() and path.read_text() for path in paths[:count]):
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    programs = (_program(path.name, _WAIT, path) for path in paths)
    assert Processes(count).run(programs) == 128 + signal.SIGINT
    thread.join()
    assert [path.read_text() for path in paths[:count]] == [str(int(signal.SIGINT))] * count
    assert not paths[count].exists()


def test_program_that_does_not_exist_is_an_error() -> None:
    with pytest.raises(FileNotFoundError, match="no-such-program"):
        Processes(2).run([Program("missing", ["no-such-program"], lambda: None)])


def test_time_limit_is_divided(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    code = "import sys, time; print(*sys.argv[1:]); time.sleep(1.5)"
    Processes(1, time_limit=1).run(_program(label, code) for label in ("one", "two"))
    label, words = capfd.readouterr().out.splitlines()
    assert label == "one", "the time is over before the second"
    option, left = words.split()
    assert option == "--time-limit"
    assert 0 < float(left) <= 1


def _install_mps(folder: Path, code: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Puts a shell script in the place of NVIDIA's program."""
    script = folder / "nvidia-cuda-mps-control"
    script.write_text(f"#!/bin/sh\n{code}\n")
    script.chmod(0o755)
    monkeypatch.setenv("PATH", str(folder), prepend=os.pathsep)
    monkeypatch.delenv("CUDA_MPS_PIPE_DIRECTORY", raising=False)


_SHOW_PIPES = "import os; print(os.environ.get('CUDA_MPS_PIPE_DIRECTORY'))"


def test_mps_is_started_for_several_programs_and_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    code = 'echo "mps $1 $CUDA_MPS_PIPE_DIRECTORY"; [ "$1" ] || cat'
    _install_mps(tmp_path, code, monkeypatch)
    Processes(2).run([_program("one", _SHOW_PIPES)])
    begin, label, found, end, command = capfd.readouterr().out.splitlines()
    folder = begin.removeprefix("mps -d ")
    assert (label, found) == ("one", f"one: {folder}")
    assert (end.split(), command) == (["mps", folder], "quit")
    assert not Path(folder).exists()
    Processes(1).run([_program("one", _SHOW_PIPES)])
    assert capfd.readouterr().out.splitlines() == ["one", "None"]


def test_programs_run_without_mps_that_does_not_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    _install_mps(tmp_path, "exit 1", monkeypatch)
    Processes(2).run([_program("one", _SHOW_PIPES)])
    problem, *lines = capfd.readouterr().out.splitlines()
    assert "programs use a GPU in turns" in problem
    assert lines == ["one", "one: None"]
