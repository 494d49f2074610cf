"""A server with pages."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from procgen_client import ServerProcess

# Longer than any response takes, on the slowest machine and under sanitizers.
TIMEOUT_S = 60.0


def built(program: str) -> Path:
    """A built program: next to PROCGEN_SERVER_BINARY, else the newest build of this checkout."""
    if "PROCGEN_SERVER_BINARY" in os.environ:
        return Path(os.environ["PROCGEN_SERVER_BINARY"]).parent / program
    found = list(Path(__file__).resolve().parents[3].glob(f"build/*/bin/{program}"))
    assert found, f"no {program} was built"
    return max(found, key=lambda path: path.stat().st_mtime)


class WebServer(NamedTuple):
    """A running server with pages."""

    process: ServerProcess
    url: str
    log_path: Path

    @property
    def port(self) -> int:
        return int(self.url.rstrip("/").rsplit(":", 1)[1])


@contextlib.contextmanager
def serve(folder: Path, *flags: str) -> Iterator[WebServer]:
    """Runs a server with pages; expects that it exits with status 0."""
    log_path = folder / "server.log"
    with ServerProcess(
        built("procgen-server"),
        ["--workers=2", "--web_address=127.0.0.1:0", *flags],
        log_path=log_path,
    ) as process:
        url = re.search(r" web=(\S+)", log_path.read_text())
        assert url is not None, log_path.read_text()
        yield WebServer(process, url.group(1), log_path)
        assert process.stop() == 0, log_path.read_text()
