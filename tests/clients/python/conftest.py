"""Fixtures: pools in both places, and one server for all tests of a run."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from procgen_client import Batch, Client, Pool, ServerProcess
from procgen_client._place import SERVER_VARIABLE
from procgen_client.batch import BATCH_ARRAYS
from procgen_client.tools.server_process import BINARY_VARIABLE

_ROOT = Path(__file__).resolve().parents[3]


MakePool = Callable[..., Pool]
# Arrays of a batch, of which each row is valid.
_OTHERS = ("observations", "final_observations", "fingerprints")
ROWS = tuple(name for name in BATCH_ARRAYS if name not in _OTHERS)


def server_binary() -> Path:
    """The path in PROCGEN_SERVER_BINARY, else the newest build of this checkout."""
    if BINARY_VARIABLE in os.environ:
        return Path(os.environ[BINARY_VARIABLE])
    built = list(_ROOT.glob("build/*/bin/procgen-server"))
    if not built:
        pytest.exit(f"no server was built; build it, or set {BINARY_VARIABLE}", returncode=2)
    return max(built, key=lambda path: path.stat().st_mtime)


def assert_same(one: Batch, other: Batch, rows: slice = slice(None)) -> None:
    """Compares all valid values of two batches, the second restricted to these rows."""
    for name in (*ROWS, "observations"):
        expected = getattr(other, name)
        expected = None if expected is None else expected[rows]
        np.testing.assert_array_equal(getattr(one, name), expected, err_msg=name)
    for name in ("fingerprints", "final_observations"):
        values, others = getattr(one, name), getattr(other, name)
        assert (values is None) == (others is None), name
        if values is not None:
            ended = one.ended
            np.testing.assert_array_equal(values[ended], others[rows][ended], err_msg=name)


def pytest_configure(config: pytest.Config) -> None:
    """Registers the mark of tests that run in a CTest test of their own, with the label slow."""
    config.addinivalue_line("markers", "slow: takes long, and a quicker test is similar")
    os.environ.pop(SERVER_VARIABLE, None)


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


@pytest.fixture(params=["process", "server"])
def place(request: pytest.FixtureRequest) -> Client | None:
    """Each place of pools, as their argument `server`."""
    return None if request.param == "process" else request.getfixturevalue("client")


@pytest.fixture
def make_pool(place: Client | None) -> Iterator[MakePool]:
    """Makes pools in each place, and closes them after the test."""
    with contextlib.ExitStack() as stack:

        yield lambda *arguments, **options: stack.enter_context(
            Pool(*arguments, server=place, **options)
        )
