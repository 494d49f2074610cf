"""No thread can be started: the call fails and the server continues."""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
import threading
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import pytest
from page import open_page
from testbed import STOP_GRACE_S, Server, run, shared_pool, wait_until

from procgen_client import Client, errors

pytestmark = pytest.mark.skipif(
    os.geteuid() != 0,
    reason="process limits are per user: only root can run the server as an unused user",
)

# A user id of this test alone.
_USER = 100_000 + os.getpid() % 100_000
_AS_USER = ["setpriv", f"--reuid={_USER}", f"--regid={_USER}", "--clear-groups"]


@contextlib.contextmanager
def _as_user() -> Iterator[None]:
    """Runs the block with the server's user id."""
    os.setegid(_USER)
    os.seteuid(_USER)
    try:
        yield
    finally:
        os.seteuid(0)
        os.setegid(0)


def test_without_threads_a_page_gets_a_retry_error(tmp_path: Path) -> None:
    async def look(url: str, server: Server) -> None:
        async with open_page(url):
            server.allow_threads(0)
            async with open_page(url, says_hello=False) as page:
                code, reason = await page.closed()
                assert code == 1013  # try again later
                assert reason.startswith("cannot start a thread")
            with urllib.request.urlopen(url, timeout=20) as index:
                assert index.status == 200
            server.allow_threads(None)
            async with open_page(url) as page:
                await page.call("pools.follow")

    flags = ["--workers=1", "--web_address=127.0.0.1:0"]
    with run(*flags, log_path=tmp_path / "log", prefix=_AS_USER) as server:
        asyncio.run(look(server.log_field("web"), server))
        assert server.stop() == 0


def test_without_threads_the_pipes_close_and_the_stream_continues(
    tmp_path: Path,
) -> None:
    with run("--workers=1", log_path=tmp_path / "log", prefix=_AS_USER) as server:
        with shared_pool(server) as pool, pool.attach() as learner:
            offer = learner.attached.shared_memory.pipe_transport
            server.allow_threads(0)
            with _as_user(), socket.socket(socket.AF_UNIX) as connection:
                connection.settimeout(20)
                connection.connect("\0" + offer.socket_name)
                with contextlib.suppress(BrokenPipeError, ConnectionResetError):
                    connection.sendall(offer.key)
                    assert connection.recv(1) == b""
            server.allow_threads(None)
            assert learner.step().last
        assert server.stop() == 0


def test_without_threads_a_fleet_rejects_a_pool(tmp_path: Path) -> None:
    cluster = [f"--cluster=threads-{os.getpid()}", f"--cluster_domain={100 + os.getpid() % 100}"]
    flags = [*cluster, "--workers=1"]
    with run(*flags, "--node_id=node", log_path=tmp_path / "log-node"), run(
        *flags, "--node_id=fleet", "--fleet", log_path=tmp_path / "log", prefix=_AS_USER
    ) as fleet, Client(fleet.address) as client:
        wait_until(lambda: len(client.list_nodes().nodes) == 2, "the fleet sees its node")
        with client.create_pool("coinrun", 4) as pool:
            pool.step([4] * 4)
            fleet.allow_threads(0)
            with pytest.raises(errors.ResourceExhaustedError, match="cannot start a thread"):
                client.create_pool("coinrun", 4)
            pool.step([4] * 4)
            fleet.allow_threads(None)
            client.create_pool("coinrun", 4).close()
        assert fleet.stop() == 0


def _learn(address: str) -> None:
    with contextlib.suppress(errors.ProcgenError), Client(address, timeout=2) as client:
        client.create_pool("coinrun", 4).step([4] * 4)


def test_without_threads_a_server_stops_on_request(tmp_path: Path) -> None:
    flags = ["--workers=1", "--drain_timeout=0s"]
    with run(*flags, log_path=tmp_path / "log", prefix=_AS_USER) as server:
        server.allow_threads(0)
        # gRPC would start more threads, and may abort without them.
        learners = [threading.Thread(target=_learn, args=[server.address]) for _ in range(20)]
        for learner in learners:
            learner.start()
        for learner in learners:
            learner.join()
        # 0: regular exit; 3: the watchdog ended the process.
        assert server.stop(STOP_GRACE_S + 10) in (0, 3)
        assert "event=stop" in server.log().splitlines()[-1]


@pytest.mark.parametrize("thread_count", [1, 2, 4, 8, 12, 16, 32])
def test_without_threads_startup_fails_with_a_message(thread_count: int, tmp_path: Path) -> None:
    limit = ["prlimit", f"--nproc={thread_count}"]
    with run("--workers=4", log_path=tmp_path / "log", prefix=[*_AS_USER, *limit]) as server:
        assert server.process.wait(30) == 1
        assert "event=start_failed" in server.log()
        assert "cannot start a thread" in server.log()
