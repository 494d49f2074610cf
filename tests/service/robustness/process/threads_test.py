"""No thread can be started: the call fails and the server continues."""

from __future__ import annotations

import asyncio
import contextlib
import os
import threading
import urllib.request
from pathlib import Path

import pytest
from page import open_page
from testbed import STOP_GRACE_S, Server, run

from procgen_client import Client, errors

pytestmark = pytest.mark.skipif(
    os.geteuid() != 0,
    reason="process limits are per user: only root can run the server as an unused user",
)

# A user id of this test alone.
_USER = 100_000 + os.getpid() % 100_000
_AS_USER = ["setpriv", f"--reuid={_USER}", f"--regid={_USER}", "--clear-groups"]


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


def _learn(address: str) -> None:
    with contextlib.suppress(errors.ProcgenError), Client(address, timeout=2) as client:
        client.create_pool("coinrun", 4).step([4] * 4)


def test_without_threads_a_server_stops_on_request(tmp_path: Path) -> None:
    with run("--workers=1", log_path=tmp_path / "log", prefix=_AS_USER) as server:
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
