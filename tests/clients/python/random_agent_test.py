"""The random agents in Python and C++ play against a real server."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from procgen_client import ServerProcess

_EXAMPLES = Path(__file__).resolve().parents[3] / "clients/python/examples"


@pytest.mark.parametrize("language", ["python", "cpp"])
def test_it_plays(server: ServerProcess, language: str) -> None:
    if language == "cpp":
        program = [os.environ["PROCGEN_CPP_RANDOM_AGENT"]]
    else:
        program = [sys.executable, str(_EXAMPLES / "random_agent.py")]
    run = subprocess.run(
        [*program, server.address, "maze"], capture_output=True, text=True, check=True
    )
    assert re.fullmatch(r"[1-9]\d* episodes of maze\n", run.stdout)
