"""CPU affinity, incomplete requests for metrics."""

from __future__ import annotations

import os
import socket
import urllib.request
from pathlib import Path

import pytest
from testbed import run


def test_workers_follow_the_cpu_affinity(tmp_path: Path) -> None:
    core = min(os.sched_getaffinity(0))
    prefix = ["taskset", "-c", str(core)]
    with run(log_path=tmp_path / "log", prefix=prefix) as server:
        assert server.log_field("workers") == "1"


@pytest.mark.parametrize("half", [b"", b"GET /metr", b"GET /metrics HTTP/1.1\r\nHost: x\r\n"])
def test_incomplete_requests_do_not_block_the_metrics_page(
    half: bytes, tmp_path: Path
) -> None:
    flags = ["--workers=1", "--metrics_address=127.0.0.1:0"]
    with run(*flags, log_path=tmp_path / "log") as server:
        host, port = server.log_field("metrics").rsplit(":", 1)
        strangers = [socket.create_connection((host, int(port))) for _ in range(16)]
        for stranger in strangers:
            stranger.sendall(half)
        url = f"http://{host}:{port}/metrics"
        with urllib.request.urlopen(url, timeout=10) as page:
            assert b"procgen_" in page.read()
        for stranger in strangers:
            stranger.close()
