"""Jobs run in processes, report, and end with the program."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from procgen_client import errors
from procgen_client.dataset import jobs

_Report = Callable[[int], None]
# A program with two jobs, which touch files and then work until they are stopped.
_PROGRAM = """
import sys
from jobs_test import work_until_stopped
from procgen_client.dataset import jobs
if __name__ == "__main__":
    jobs.run(work_until_stopped, sys.argv[1:], 2, lambda _: None)
"""


def work_until_stopped(path: str, report: _Report) -> None:
    """Writes the number of the process, and reports steps until that raises."""
    Path(path).write_text(f"{os.getpid()}\n")
    while True:
        time.sleep(0.01)
        report(1)


def _write(path: Path, report: _Report) -> None:
    report(5)
    path.write_text(str(os.getpid()))
    report(2)


def _fail(path: Path, report: _Report) -> None:
    if path.name == "0":
        raise errors.DataLossError("zero is damaged")
    work_until_stopped(str(path), report)


def _die(path: Path, report: _Report) -> None:
    if path.name == "0":
        os.kill(os.getpid(), signal.SIGKILL)
    work_until_stopped(str(path), report)


@pytest.mark.parametrize("workers", [1, 2])
def test_every_job_runs_and_reports(tmp_path: Path, workers: int) -> None:
    counts: list[int] = []
    jobs.run(_write, [tmp_path / str(i) for i in range(5)], workers, counts.append)
    processes = {path.read_text() for path in tmp_path.iterdir()}
    assert len(list(tmp_path.iterdir())) == 5
    assert (str(os.getpid()) in processes) == (workers == 1)
    assert counts[-1] == 5 * 7
    assert counts == sorted(counts)


def test_first_error_stops_the_others(tmp_path: Path) -> None:
    with pytest.raises(errors.DataLossError, match="zero is damaged"):
        jobs.run(_fail, [tmp_path / str(i) for i in range(5)], 2, lambda _: None)


def test_killed_worker_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(errors.ProcgenError, match="a worker process was killed"):
        jobs.run(_die, [tmp_path / str(i) for i in range(5)], 2, lambda _: None)


def _lives(process_id: int) -> bool:
    try:
        state = Path(f"/proc/{process_id}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state not in "ZX"


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_workers_end_with_the_program(tmp_path: Path, number: signal.Signals) -> None:
    (tmp_path / "program.py").write_text(_PROGRAM)
    path = f"{Path(__file__).parent}:{os.environ['PYTHONPATH']}"
    with subprocess.Popen(
        [sys.executable, str(tmp_path / "program.py"), str(tmp_path / "0"), str(tmp_path / "1")],
        env={**os.environ, "PYTHONPATH": path},
        stderr=subprocess.PIPE,
        text=True,
    ) as program:
        files = [tmp_path / "0", tmp_path / "1"]
        while not all(file.exists() and file.read_text().endswith("\n") for file in files):
            assert program.poll() is None, program.stderr
            time.sleep(0.01)
        workers = [int(file.read_text()) for file in files]
        assert all(map(_lives, workers))
        program.send_signal(number)
        _, said = program.communicate()
    while any(map(_lives, workers)):  # The timeout of the test bounds it.
        time.sleep(0.01)
    assert program.returncode == -number
    assert ("KeyboardInterrupt" in said) == (number == signal.SIGINT)
