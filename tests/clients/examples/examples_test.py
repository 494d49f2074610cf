"""The agent in clients/examples/$PROCGEN_EXAMPLE, run as its README describes."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import time
import urllib.request
from pathlib import Path

import pytest

from procgen_client import Client, ServerProcess

_LANGUAGE = os.environ["PROCGEN_EXAMPLE"]
_RUN = Path(__file__).resolve().parents[3] / "clients/examples" / _LANGUAGE / "run.sh"
_BUILD = os.environ["PROCGEN_EXAMPLE_BUILD"]
_HAS_LIBRARY = _LANGUAGE.startswith("libprocgen_")
_NO_REGISTRY = 69  # Exit status of run.sh: packages cannot be downloaded.


def _start(address: str, steps: int) -> subprocess.Popen[str]:
    command = ["sh", str(_RUN), _BUILD, address, str(steps)]
    libraries = {"PROCGEN_LIBRARIES": str(Path(os.environ["PROCGEN_REMOTE_LIBRARY"]).parent)}
    return subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, **libraries},
    )


@pytest.fixture(autouse=True)
def _tools() -> None:
    (tools,) = re.findall(r"^# Needs (.*)\.$", _RUN.read_text(), re.MULTILINE)
    missing = [tool for tool in tools.split(", ") if shutil.which(tool) is None]
    if missing:
        pytest.skip(f"{_LANGUAGE}: there is no {', '.join(missing)}")


def _output(process: subprocess.Popen[str]) -> str:
    output, complaints = process.communicate()
    if process.returncode == _NO_REGISTRY:
        pytest.skip(f"{_LANGUAGE}: {complaints}")
    assert process.returncode == 0, complaints
    return output


def _episodes(server_log: Path) -> tuple[int, float]:
    """Returns the number of episodes that a server has counted, and their mean return."""
    address = re.search(r"metrics=(\S+)", server_log.read_text()).group(1)
    with urllib.request.urlopen(f"http://{address}/metrics") as page:
        text = page.read().decode()
    found = re.findall(r"^procgen_episode_return_(sum|count){.*} (\S+)", text, re.MULTILINE)
    values = {name: float(value) for name, value in found}
    return int(values["count"]), values["sum"] / values["count"]


def test_it_reports_the_episodes_that_the_server_counted(tmp_path: Path) -> None:
    log = tmp_path / "log"
    with ServerProcess(flags=["--metrics_address=127.0.0.1:0"], log_path=log) as server:
        output = _output(_start(server.address, 2000))
        count, mean = _episodes(log)
    assert count > 0
    assert f"{count} episodes, mean return {mean:.3f}\n" in output


def test_it_continues_on_a_restarted_server() -> None:
    steps = 10000
    with ServerProcess() as server:
        process = _start(server.address, steps)
        with Client(server.address) as client:
            while process.poll() is None and not _steps(client) > 500 * 4:
                time.sleep(0.02)
        os.kill(server.process_id, signal.SIGKILL)
        server.stop()
    with ServerProcess(address=server.address) as server:
        output = _output(process)
    if _HAS_LIBRARY:  # It continues by itself; results are those of an undisturbed pool.
        assert output == _output(_start("", steps))
        return
    continued = int(re.search(r"continuing after (\d+) steps", output).group(1))
    assert 500 <= continued + 100 <= steps  # It saves its environments every 100 steps.
    (count,) = re.findall(r"(\d+) episodes, mean return [\d.]+\n", output)
    assert int(count) > 4 * steps / 1000  # An episode has at most 1,000 steps.


def _steps(client: Client) -> int:
    return sum(pool.step_count for pool in client.list_pools())
