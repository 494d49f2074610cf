"""Fixtures: testbeds, and the expected trace of all scenarios."""

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

# Number of requests per scenario; the full form uses 20,000.
_REQUESTS_VARIABLE = "PROCGEN_FLEET_FAULTS_REQUESTS"
_REQUESTS_DEFAULT = 2000


def pytest_configure() -> None:
    """Handles SIGTERM like Ctrl-C, so that fixtures remove the hosts."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)


@pytest.fixture(scope="session")
def script() -> Script:
    """The learner's script in all scenarios."""
    return Script(request_count=int(os.environ.get(_REQUESTS_VARIABLE, _REQUESTS_DEFAULT)))


@pytest.fixture(scope="session")
def expected(script: Script, tmp_path_factory: pytest.TempPathFactory) -> Trace:
    """The trace of the script on one server."""
    try:
        return single_server_trace(script, tmp_path_factory.mktemp("single"))
    except NotPermittedError as error:
        pytest.skip(str(error))


@pytest.fixture
def testbed(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Testbed]:
    """A fleet that uses multicast for discovery, or --cluster_peers with the marker `peers`."""
    try:
        made = Testbed(tmp_path, multicast=request.node.get_closest_marker("peers") is None)
    except NotPermittedError as error:
        pytest.skip(str(error))
    with made:
        yield made
