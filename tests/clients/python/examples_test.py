"""The examples do what their first lines describe, with a real server."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from procgen_client import ServerProcess

_EXAMPLES = Path(__file__).resolve().parents[3] / "clients/python/examples"


def _run(name: str, *arguments: str) -> str:
    run = subprocess.run(
        [sys.executable, str(_EXAMPLES / name), *arguments],
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    return run.stdout


def test_branching_improves_on_the_first_round(server: ServerProcess) -> None:
    said = _run("branch_and_search.py", server.address, "--rounds", "8")
    returns = [float(number) for number in re.findall(r"round \d+: return ([\d.]+)", said)]
    assert len(returns) > 1
    assert returns == sorted(returns), "returns never decrease"
    assert returns[-1] > returns[0]
    assert said.endswith(f"return {returns[-1]:.1f} in level 7 of bigfish\n")


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is missing")
def test_video_is_recorded(server: ServerProcess, tmp_path: Path) -> None:
    path = tmp_path / "coinrun.mp4"
    assert _run("record_video.py", server.address, str(path)) == f"100 frames in {path}\n"
    assert path.stat().st_size > 10_000
