"""The wall clock moves by an hour, and no wait is affected."""

from __future__ import annotations

import asyncio
import os
import time
from pathlib import Path

import pytest
from page import open_page
from testbed import WallClock, run, wait_until

from procgen_client import Client

_HOUR_S = 3600
# Abseil's clock follows the machine's clock within 2.5 s.
_NOTICED_S = 3.0
_jumps = pytest.mark.parametrize("jump_s", [-_HOUR_S, _HOUR_S], ids=["back", "forth"])


def pool_has_stepped(client: Client) -> bool:
    """Whether the only pool of the server has stepped."""
    return client.list_pools()[0].step_count > 0


@_jumps
def test_drain_ignores_the_wall_clock(jump_s: int, tmp_path: Path) -> None:
    clock = WallClock(tmp_path)
    with run("--workers=1", log_path=tmp_path / "log", environment=clock.environment) as server:
        with Client(server.address) as client:
            pool = client.create_pool("coinrun", 4096)
            pool.send_step([4] * 4096)  # 50 MB that nobody reads keep the drain waiting.
            wait_until(lambda: pool_has_stepped(client), "the batch is drawn")
            begun = time.monotonic()
            server.process.terminate()
            wait_until(lambda: "event=draining" in server.log(), "the drain has begun")
            clock.move(jump_s)
            assert server.process.wait(30) == 0
            assert 0.8 < time.monotonic() - begun < 8
        assert "event=stopped" in server.log()


@_jumps
def test_pages_work_after_a_clock_change(jump_s: int, tmp_path: Path) -> None:
    async def look(url: str, clock: WallClock) -> None:
        async with open_page(url) as page:
            await page.call("pools.follow")
            await page.event("pools")
            clock.move(jump_s)
            begun = time.monotonic()
            while time.monotonic() - begun < _NOTICED_S + 2:
                await page.event("pools")
            assert not page.has_event("pools_closed")
            # More than the rate limit's burst, so some requests wait.
            await asyncio.gather(*[page.call("pools.unfollow") for _ in range(250)])
            assert time.monotonic() - begun < 30

    clock = WallClock(tmp_path)
    flags = ["--workers=1", "--web_address=127.0.0.1:0"]
    with run(*flags, log_path=tmp_path / "log", environment=clock.environment) as server:
        asyncio.run(look(server.log_field("web"), clock))
        assert server.stop() == 0


@_jumps
def test_nodes_stay_in_the_cluster_after_a_clock_change(jump_s: int, tmp_path: Path) -> None:
    clock = WallClock(tmp_path)
    cluster = [f"--cluster=clock-{os.getpid()}", f"--cluster_domain={100 + os.getpid() % 100}"]
    flags = [*cluster, "--workers=1"]
    log = tmp_path / "log"
    with run(*flags, "--node_id=a", log_path=tmp_path / "log-a") as first, run(
        *flags, "--node_id=b", log_path=log, environment=clock.environment
    ) as second, Client(first.address) as a, Client(second.address) as b:
        for client in (a, b):
            wait_until(lambda: len(client.list_nodes().nodes) == 2, "both nodes are seen")
        clock.move(jump_s)
        begun = time.monotonic()
        while time.monotonic() - begun < _NOTICED_S + 6:
            assert len(a.list_nodes().nodes) == 2
            time.sleep(0.2)
        with a.create_pool("coinrun", 3, pool_id="late"):
            wait_until(
                lambda: sorted(node.pool_count for node in b.list_nodes().nodes) == [0, 1],
                "the node receives the other's status",
                10,
            )
