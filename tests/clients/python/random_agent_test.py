"""The random agents play."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path


from procgen_client import ServerProcess

_CLIENTS = Path(__file__).resolve().parents[3] / "clients"
_AGENTS = {
    "cpp": "cpp/examples/random_agent.cc",
    "python": "python/examples/random_agent.py",
}


def _played(*command: str) -> str:
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    return run.stdout


def test_python_agent_plays_in_the_process_and_on_a_server(server: ServerProcess) -> None:
    command = [sys.executable, str(_CLIENTS / _AGENTS["python"]), "--game", "maze"]
    for place in ([], ["--server", server.address]):
        assert re.fullmatch(r"[1-9]\d* episodes of maze\n", _played(*command, *place))


def test_cpp_agent_plays_on_a_server(server: ServerProcess) -> None:
    program = os.environ["PROCGEN_CPP_RANDOM_AGENT"]
    assert re.fullmatch(r"[1-9]\d* episodes of maze\n", _played(program, server.address, "maze"))
