"""Fixtures: testbeds, and the expected trace of all scenarios."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path

import pytest
from learner_script import Script
from learner_trace import Trace
from network import NotPermittedError
from testbed import SERVERS, Testbed, undisturbed_trace

# Number of requests per scenario; the full form uses 20,000.
_REQUESTS_VARIABLE = "PROCGEN_FAULTS_REQUESTS"
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
        return undisturbed_trace(script, tmp_path_factory.mktemp("expected"))
    except NotPermittedError as error:
        pytest.skip(str(error))


@pytest.fixture
def make_testbed(tmp_path: Path) -> Iterator[Callable[[Sequence[str]], Testbed]]:
    """Makes testbeds, by default of three servers, and removes them at the end of the test."""
    with ExitStack() as stack:

        def make(hosts: Sequence[str] = SERVERS) -> Testbed:
            try:
                return stack.enter_context(Testbed(tmp_path, hosts))
            except NotPermittedError as error:
                pytest.skip(str(error))

        yield make
