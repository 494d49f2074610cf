"""The random agents run with a real server, and are as short as documented."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from procgen_client import ServerProcess

_CLIENTS = Path(__file__).resolve().parents[3] / "clients"
_AGENTS = {
    "cpp": "cpp/examples/random_agent.cc",
    "go": "go/examples/random_agent/main.go",
    "node": "node/examples/random_agent.js",
    "python": "python/examples/random_agent.py",
}
_LINES_MAX = 15
# Lines that every program of the language needs.
_FRAME = re.compile(
    r"#!|\s*(//|#include|\}?$|import |package |\"[\w/]+\"$|\)$)|\"\"\"|(func|int) main|import \($"
)


@pytest.mark.parametrize("language", ["python", "cpp"])
def test_random_agent_plays(server: ServerProcess, language: str) -> None:
    if language == "cpp":
        program = [os.environ["PROCGEN_CPP_RANDOM_AGENT"]]
    else:
        program = [sys.executable, str(_CLIENTS / _AGENTS["python"])]
    run = subprocess.run(
        [*program, server.address, "maze"], capture_output=True, text=True, check=True
    )
    assert re.fullmatch(r"[1-9]\d* episodes of maze\n", run.stdout)


@pytest.mark.parametrize("language", _AGENTS)
def test_random_agent_is_as_short_as_documented(language: str) -> None:
    lines = (_CLIENTS / _AGENTS[language]).read_text().splitlines()
    own = [line for line in lines if not _FRAME.match(line)]
    assert 5 < len(own) <= _LINES_MAX, own
