"""Fixtures: testbeds, and the trace that all scenarios are held to."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from learner_script import Script
from learner_trace import Trace
from network import NotPermittedError
from testbed import Testbed, single_server_trace

# How many requests a scenario has; 20,000 in full.
_REQUESTS_VARIABLE = "PROCGEN_FLEET_FAULTS_REQUESTS"
_REQUESTS_DEFAULT = 2000


def pytest_configure() -> None:
    """Being told to end is as Ctrl-C: hosts are removed on the way out."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)


@pytest.fixture(scope="session")
def script() -> Script:
    """What the learner of every scenario does."""
    return Script(request_count=int(os.environ.get(_REQUESTS_VARIABLE, _REQUESTS_DEFAULT)))


@pytest.fixture(scope="session")
def expected(script: Script, tmp_path_factory: pytest.TempPathFactory) -> Trace:
    """What it sees of one server."""
    try:
        return single_server_trace(script, tmp_path_factory.mktemp("single"))
    except NotPermittedError as error:
        pytest.skip(str(error))


@pytest.fixture
def testbed(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Testbed]:
    """A fleet whose servers find each other by multicast; not so with the marker `peers`."""
    try:
        made = Testbed(tmp_path, multicast=request.node.get_closest_marker("peers") is None)
    except NotPermittedError as error:
        pytest.skip(str(error))
    with made:
        yield made
