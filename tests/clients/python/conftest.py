"""Fixtures: one server for all tests of a run, on a port that the system chooses."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from procgen_client import Client, ServerProcess
from procgen_client._transport import is_native
from procgen_client.tools.server_process import BINARY_VARIABLE

_ROOT = Path(__file__).resolve().parents[3]
# Marks tests that need the native module.
native_only = pytest.mark.skipif(not is_native(), reason="the native module is missing")
ENCODINGS = ["raw", pytest.param("delta_zstd", marks=native_only)]


def server_binary() -> Path:
    """The path in PROCGEN_SERVER_BINARY, else the newest build of this checkout."""
    if BINARY_VARIABLE in os.environ:
        return Path(os.environ[BINARY_VARIABLE])
    built = list(_ROOT.glob("build/*/bin/procgen-server"))
    if not built:
        pytest.exit(f"no server was built; build it, or set {BINARY_VARIABLE}", returncode=2)
    return max(built, key=lambda path: path.stat().st_mtime)


def pytest_configure(config: pytest.Config) -> None:
    """Registers the mark of tests that run in a CTest test of their own, with the label slow."""
    config.addinivalue_line("markers", "slow: takes long, and a quicker test is similar")


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerProcess]:
    """A server that stops after the last test and must exit with status 0."""
    log_path = tmp_path_factory.mktemp("server") / "server.log"
    with ServerProcess(server_binary(), ["--workers=2"], log_path=log_path) as process:
        yield process
        assert process.stop() == 0, log_path.read_text()


@pytest.fixture
def client(server: ServerProcess) -> Iterator[Client]:
    """A client of this test."""
    with Client(server.address) as connected:
        yield connected


@pytest.fixture
def saved_figures(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The figures that matplotlib saves during the test; skips the test without matplotlib."""
    figure_class = pytest.importorskip("matplotlib.figure").Figure
    figures: list[Any] = []
    save = figure_class.savefig

    def savefig(figure: Any, *arguments: Any, **options: Any) -> None:  # noqa: ANN401
        figures.append(figure)
        save(figure, *arguments, **options)

    monkeypatch.setattr(figure_class, "savefig", savefig)
    return figures
