"""Pages pause learners and let single requests pass."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from learner import Learner
from page import TIMEOUT_S, Page, PageError, WebServer, open_page, serve

from procgen_client import Client


async def _wait_for(page: Page, condition: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    """Returns the server's only pool once it satisfies the condition."""
    while True:
        pools = (await page.event("pools")).result["pools"]
        if pools and condition(pools[0]):
            return pools[0]


async def _settled_steps(page: Page) -> int:
    """Returns the step count of the paused pool once it no longer changes."""
    before = -1
    while True:
        pool = await _wait_for(page, lambda pool: bool(pool["paused"]))
        if pool["step_count"] == before:
            return before
        before = pool["step_count"]


def test_a_page_pauses_a_learner_and_lets_single_steps_pass(server: WebServer) -> None:
    async def test() -> None:
        with Client(server.process.address) as client, client.create_pool("coinrun", 20) as pool:
            learner = Learner(pool)
            try:
                async with open_page(server.url) as page, open_page(server.url) as other:
                    await page.call("pools.follow")
                    await _wait_for(page, lambda it: it["step_count"] > 0)  # the first is slow
                    await page.call("pool.pause", pool=pool.name)
                    await page.call("pool.pause", pool=pool.name)  # no effect
                    steps = await _settled_steps(page)
                    with pytest.raises(PageError, match="this page has not paused"):
                        await other.call("pool.step", pool=pool.name)
                    for _ in range(3):
                        await page.call("pool.step", pool=pool.name)
                    assert await _settled_steps(page) == steps + 3 * 20
                    # Frames show the newest step.
                    await page.call(
                        "watch.start", pool=pool.name, environments=[0], size_px=64,
                        with_steps=True,
                    )  # fmt: skip
                    await page.event("frames")
                    await page.call("pool.step", pool=pool.name)
                    (entry,) = (await page.event("frames")).entries
                    assert entry["step"]["action"] == 7
                    # A pause lasts until each page has ended its own.
                    await other.call("pool.pause", pool=pool.name)
                    await page.call("pool.resume", pool=pool.name)
                    assert await _settled_steps(page) == steps + 4 * 20
                    await other.socket.close()
                    await _wait_for(page, lambda it: not it["paused"])
                    await _wait_for(page, lambda it: it["step_count"] > steps + 10 * 20)
            finally:
                learner.stop()

    asyncio.run(test())


def test_a_paused_pool_ends_with_its_learner(server: WebServer) -> None:
    async def test() -> None:
        async with open_page(server.url) as page:
            await page.call("pools.follow")
            with Client(server.process.address) as client:
                pool = client.create_pool("coinrun", 20, pool_id="left")
                await page.call("pool.pause", pool=pool.name)
                pool.send_step(np.full(20, 7))
                paused = await _wait_for(page, lambda it: bool(it["paused"]))
                assert paused["step_count"] == 0
            while (await page.event("pools")).result["pools"]:
                pass

    asyncio.run(test())


def test_a_page_cannot_pause_the_pools_that_it_steps(tmp_path: Path) -> None:
    """It would wait for itself, and keep its place among --web_viewers_max."""

    async def test(server: WebServer) -> None:
        with Client(server.process.address) as client:
            for _ in range(3):
                async with open_page(server.url) as page:
                    play = await page.call(
                        "play.start", game="coinrun", mode="easy", level_seed=1, human_size_px=0
                    )
                    (pool,) = client.list_pools()
                    with pytest.raises(PageError, match=f"{pool.name} belongs to a page"):
                        await page.call("pool.pause", pool=pool.name)
                    await page.call("play.step", play=play.result["play"], action=7)
                while client.list_pools():
                    await asyncio.sleep(0.01)

    with serve(tmp_path, "--web_viewers_max=2") as server:
        asyncio.run(asyncio.wait_for(test(server), TIMEOUT_S))
