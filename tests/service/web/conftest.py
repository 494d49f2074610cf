"""Fixtures: one real server with pages for all tests of a file, on ports that the system chose."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from page import WebServer, serve

_ROOT = Path(__file__).resolve().parents[3]


def built(program: str) -> Path:
    """A program of this build: what CTest says, else what was built last in this checkout."""
    if "PROCGEN_SERVER_BINARY" in os.environ:
        return Path(os.environ["PROCGEN_SERVER_BINARY"]).parent / program
    found = list(_ROOT.glob(f"build/*/bin/{program}"))
    if not found:
        pytest.exit(f"no {program} was built", returncode=2)
    return max(found, key=lambda path: path.stat().st_mtime)


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WebServer]:
    with serve(built("procgen-server"), tmp_path_factory.mktemp("server")) as running:
        yield running
