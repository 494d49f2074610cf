"""Fixtures: a server with pages for the tests of a file, on ports that the system chooses."""

from __future__ import annotations

from collections.abc import Iterator
import pytest
from page import WebServer, serve


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WebServer]:
    with serve(tmp_path_factory.mktemp("server")) as running:
        yield running
