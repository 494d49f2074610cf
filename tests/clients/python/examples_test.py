"""The examples do what their first lines describe, in the process and on a server."""

from __future__ import annotations

import json
import os
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
    said = _run("branch_and_search.py", "--rounds", "8")
    assert _run("branch_and_search.py", "--rounds", "8", "--server", server.address) == said
    returns = [float(number) for number in re.findall(r"round \d+: return ([\d.]+)", said)]
    assert len(returns) > 1
    assert returns == sorted(returns), "returns never decrease"
    assert returns[-1] > returns[0]
    assert said.endswith(f"return {returns[-1]:.1f} in level 7 of bigfish\n")


def test_torch_policy_is_evaluated_with_its_weights(tmp_path: Path) -> None:
    torch = pytest.importorskip("torch")
    command = [
        *(sys.executable, "-W", "error", "-m", "procgen_client.tools.evaluate", "bigfish"),
        *("--policy", "torch_policy:make_policy", "--option", "grayscale_obs=true"),
        *("--mode", "easy", "--episodes", "4", "--environments", "2"),
        *("--json", str(tmp_path / "scores.json")),
    ]
    environment = os.environ | {"PYTHONPATH": f"{os.environ['PYTHONPATH']}:{_EXAMPLES}"}

    def lengths() -> list[int]:
        subprocess.run(command, env=environment, check=True, capture_output=True)
        written = json.loads((tmp_path / "scores.json").read_text())
        return [episode["length"] for episode in written["episodes"]]

    first = lengths()
    assert len(first) == 8
    sys.path.insert(0, str(_EXAMPLES))
    from torch_policy import RecurrentNetwork

    network = RecurrentNetwork()
    torch.save(network.state_dict(), tmp_path / "weights.pt")
    environment["POLICY_WEIGHTS"] = str(tmp_path / "weights.pt")
    assert lengths() != first


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is missing")
@pytest.mark.parametrize("on_server", [False, True])
def test_video_is_recorded(server: ServerProcess, tmp_path: Path, on_server: bool) -> None:
    path = tmp_path / "coinrun.mp4"
    place = ["--server", server.address] if on_server else []
    assert _run("record_video.py", str(path), *place) == f"100 frames in {path}\n"
    assert path.stat().st_size > 10_000
