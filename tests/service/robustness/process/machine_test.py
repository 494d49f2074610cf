"""CPU affinity, unwritable folders, truncated files, incomplete requests for metrics."""

from __future__ import annotations

import os
import socket
import urllib.request
from pathlib import Path

import grpc
import pytest
from testbed import run, shared_pool

from procgen_client import Client


def test_workers_follow_the_cpu_affinity(tmp_path: Path) -> None:
    core = min(os.sched_getaffinity(0))
    prefix = ["taskset", "-c", str(core)]
    with run(log_path=tmp_path / "log", prefix=prefix) as server:
        assert server.log_field("workers") == "1"


def test_unwritable_folders_are_rejected_at_startup(tmp_path: Path) -> None:
    flags = ["--workers=1", "--shared_memory_dir=/proc"]
    with run(*flags, log_path=tmp_path / "log") as server:
        assert server.process.wait(20) == 2
        assert "--shared_memory_dir is '/proc'" in server.log()
        assert "allowed: a folder to make files in" in server.log()


def test_truncating_the_shared_file_harms_only_its_learner(tmp_path: Path) -> None:
    flags = ["--workers=2", "--drain_timeout=0s"]
    with run(*flags, log_path=tmp_path / "log") as server, shared_pool(
        server
    ) as pool, Client(server.address) as client, client.create_pool("maze", 8) as other:
        with pool.attach() as learner:
            learner.step()
            os.truncate(learner.attached.shared_memory.path, 0)
            for _ in range(10):
                assert learner.step().last
                other.step([4] * 8)
        with pytest.raises(grpc.RpcError) as raised, pool.attach():
            pass
        assert raised.value.code() == grpc.StatusCode.FAILED_PRECONDITION
        assert "has truncated" in raised.value.details()
        assert server.stop() == 0


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
