"""The live view: pools while they are stepped, their history and their frames."""

from __future__ import annotations

import asyncio
import time
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from learner import Learner
from page import TIMEOUT_S, Page, PageError, WebServer, conformance, open_page

from procgen_client import Client


@pytest.fixture
def learner(server: WebServer) -> Iterator[Learner]:
    with Client(server.process.address) as client, client.create_pool(
        "coinrun", 20, pool_id="learning", distribution_mode="easy"
    ) as pool:
        running = Learner(pool)
        yield running
        running.stop()


def run(test: Any) -> None:
    asyncio.run(test)


def test_pools_are_reported_once_a_second(server: WebServer, learner: Learner) -> None:
    async def test() -> None:
        async with open_page(server.url) as page:
            begun = time.monotonic()
            await page.call("pools.follow")
            first = await page.event("pools")
            for _ in range(3):
                last = await page.event("pools")
            assert 1.5 < time.monotonic() - begun < 30
            while (
                last.result["pools"][0]["episode_count"] == 0
                and time.monotonic() - begun < TIMEOUT_S
            ):
                last = await page.event("pools")
            (pool,) = last.result["pools"]
            assert pool["name"] == "pools/learning" and pool["kind"] == "pool"
            assert pool["games"] == ["coinrun"] and pool["mode"] == "easy"
            assert pool["env_count"] == 20 and pool["owner"] == ""
            assert pool["steps_per_second"] > 0
            assert pool["step_count"] > first.result["pools"][0]["step_count"]
            assert pool["episode_count"] > 0 and 0 <= pool["mean_return"] <= 10
            assert 0 < pool["mean_length"] <= 1000
            assert 0 < pool["request_p50_ms"] <= pool["request_p99_ms"]
            assert pool["create_time_s"] <= last.result["time_s"]
            # Pools of pages are listed and not counted.
            level = {"game": "maze", "mode": "easy", "level_seed": 1}
            play = await page.call("play.start", **level, human_size_px=0)
            rates = {"pool": 0.0}
            while not rates.get("play"):
                await page.call("play.step", play=play.result["play"], action=4)
                last = await page.event("pools")
                rates = {
                    pool["kind"]: pool["steps_per_second"] for pool in last.result["pools"]
                }
            load = last.result["server"]["load"]
            assert load["steps_per_second"] == rates["pool"]
            assert load["pool_count"] == 1 and load["env_count"] == 20
            assert load["worker_count"] == 2 and load["draining"] is False
            (node,) = last.result["nodes"]
            assert node["healthy"] is True
            await page.call("pools.unfollow")
            while page.has_event("pools"):
                await page.event("pools")
            await asyncio.sleep(1.5)
            assert not page.has_event("pools")

    run(test())


def test_a_late_page_receives_the_history(server: WebServer, learner: Learner) -> None:
    async def test() -> None:
        # No page is open meanwhile.
        await asyncio.sleep(3)
        async with open_page(server.url) as page:
            history = (await page.call("pool.history", pool="pools/learning")).result
            assert history["columns"] == [
                "time_s", "step_count", "steps_per_second", "episode_count", "mean_return",
                "mean_length", "request_p50_ms", "request_p99_ms", "return_min", "return_max",
                "return_deviation",
            ]  # fmt: skip
            assert history["games"] == []
            assert history["interval_s"] == 1 and 2 <= len(history["rows"]) <= 600
            times = [row[0] for row in history["rows"]]
            assert times == sorted(times)
            last = dict(zip(history["columns"], history["rows"][-1], strict=True))
            assert last["steps_per_second"] > 0 and last["request_p50_ms"] > 0
            if last["episode_count"] > 0:
                assert last["return_min"] <= last["mean_return"] <= last["return_max"]
            hour = (await page.call("pool.history", pool="pools/learning", span_s=3600)).result
            assert hour["interval_s"] == 10 and len(hour["rows"]) <= len(history["rows"]) + 1
            (returns,) = (await page.call("pools.returns")).result["pools"]
            assert returns["name"] == "pools/learning"
            assert 1 <= len(returns["mean_returns"]) <= 60

    run(test())


def test_episodes_are_listed_once_and_replayable(server: WebServer, learner: Learner) -> None:
    async def test() -> None:
        async with open_page(server.url) as page:
            rows: list[dict[str, Any]] = []
            while len(rows) < 30:
                after = rows[-1]["number"] if rows else 0
                answer = await page.call("pool.episodes", pool="pools/learning", after=after)
                listed = answer.result
                assert listed["pool"] == "pools/learning"
                assert listed["episode_count"] >= after
                rows += [dict(zip(listed["columns"], row, strict=True)) for row in listed["rows"]]
                await asyncio.sleep(0.2)
            assert [row["number"] for row in rows] == list(range(1, len(rows) + 1))
            assert all(0 <= row["environment"] < 20 and row["length"] > 0 for row in rows)
            assert all(row["total_reward"] == 10.0 * row["level_complete"] for row in rows)
            assert len({row["fingerprint"] for row in rows}) > 1
            learner.stop()
            end = (await page.call("pool.episodes", pool="pools/learning")).result
            newest = dict(zip(end["columns"], end["rows"][-1], strict=True))
            episode = (
                await page.call(
                    "pool.episode",
                    pool="pools/learning",
                    environment=newest["environment"],
                    selector="last",
                )
            ).result
            assert episode["fingerprint"] == newest["fingerprint"]
            assert episode["level_seed"] == newest["level_seed"]
            assert episode["total_reward"] == newest["total_reward"]
            assert episode["steps"] == newest["length"]

    run(test())


def test_frames_equal_the_environments(server: WebServer) -> None:
    async def test() -> None:
        with Client(server.process.address) as client, client.create_pool(
            "maze", 6, rand_seed=1
        ) as pool:
            seen = pool.step(np.full(6, 4)).observations
            async with open_page(server.url) as page:
                watch = (
                    await page.call(
                        "watch.start", pool=pool.name, environments=[4, 1], size_px=64,
                        frames_per_second_max=60, format="rgb",
                    )
                ).result["watch"]  # fmt: skip
                frames = await page.event("frames")
                assert frames.result["watch"] == watch
                assert [it["environment"] for it in frames.entries] == [4, 1]
                assert {it["format"] for it in frames.entries} == {"rgb"}
                assert frames.parts["environment-4"] == seen[4].tobytes()
                # No frames arrive while nothing changes.
                await asyncio.sleep(0.3)
                assert not page.has_event("frames")
                seen = pool.step(np.full(6, 7)).observations
                frames = await page.event("frames")
                assert frames.result["request_count"] == 2
                assert frames.parts["environment-1"] == seen[1].tobytes()
                await page.call("watch.stop", watch=watch)
                pool.step(np.full(6, 1))
                await asyncio.sleep(0.3)
                assert not page.has_event("frames") and not page.has_event("watch_ended")

                await page.call("watch.start", pool=pool.name, environments=[0], size_px=128)
                (entry,) = (frames := await page.event("frames")).entries
                assert (entry["format"], entry["width"]) == ("png", 128)
                assert frames.parts["environment-0"].startswith(b"\x89PNG")

    run(test())


def test_the_end_of_an_episode_is_shown_before_the_next_start(server: WebServer) -> None:
    async def test() -> None:
        with Client(server.process.address) as client, client.create_pool(
            "maze", 2, rand_seed=1
        ) as pool:
            seed = int(pool.step(np.full(2, 7)).level_seeds[1])
            async with open_page(server.url) as page:
                await page.call(
                    "watch.start", pool=pool.name, environments=[0, 1], size_px=64,
                    frames_per_second_max=60, format="rgb",
                )  # fmt: skip
                await page.event("frames")
                batch = pool.step(np.array([4, -1]), final_observations=True)
                frames = await page.event("frames")
                assert "ended_episode" not in frames.entries[0]
                assert frames.entries[1]["ended_episode"] == {
                    "return": 0, "length": 2, "level_seed": seed,
                    "level_complete": False, "truncated": False,
                }  # fmt: skip
                assert frames.parts["environment-1"] == batch.final_observations[1].tobytes()
                frames = await page.event("frames")
                assert "ended_episode" not in frames.entries[1]
                assert frames.parts["environment-1"] == batch.observations[1].tobytes()

    run(test())


async def show_frames(page: Page, request_count: int, shown: list[bytes]) -> tuple[int, int]:
    """Applies frames to `shown` until they are the state after a request.

    Returns their number and bytes.
    """
    count = size = 0
    while True:
        frames = await page.event("frames")
        count += 1
        for environment, difference in enumerate(frames.parts.values()):
            size += len(difference)
            if difference:
                inflater = zlib.decompressobj(-zlib.MAX_WBITS, zdict=shown[environment])
                shown[environment] = inflater.decompress(difference)
        assert {it["format"] for it in frames.entries} == {"deflate"}
        ends = any("ended_episode" in it for it in frames.entries)
        if frames.result["request_count"] == request_count and not ends:
            return count, size


def test_frames_are_sent_as_differences(server: WebServer) -> None:
    async def test() -> None:
        with Client(server.process.address) as client, client.create_pool(
            "coinrun", 16, rand_seed=1
        ) as pool:
            shown = [b""] * 16
            raw_bytes = 16 * 64 * 64 * 3
            async with open_page(server.url) as page:
                pool.observe()  # Request 1.
                await page.call(
                    "watch.start", pool=pool.name, environments=list(range(16)), size_px=64,
                    frames_per_second_max=60,
                )  # fmt: skip
                _, size = await show_frames(page, 1, shown)
                assert 0.05 * raw_bytes < size < raw_bytes
                total = 0
                for number, action in enumerate([7, 5, 7, 4] * 5, 2):
                    batch = pool.step(np.full(16, action))
                    _, size = await show_frames(page, number, shown)
                    assert shown == [it.tobytes() for it in batch.observations]
                    total += size
                assert total / 20 < 0.1 * raw_bytes

    run(test())


def test_a_page_that_reads_late_gets_differences_that_fit_together(server: WebServer) -> None:
    async def test() -> None:
        with Client(server.process.address) as client, client.create_pool(
            "starpilot", 64, rand_seed=1
        ) as pool:
            shown = [b""] * 64
            async with open_page(server.url) as page:
                await page.call(
                    "watch.start", pool=pool.name, environments=list(range(64)), size_px=64,
                    frames_per_second_max=60,
                )  # fmt: skip
                for _ in range(400):
                    batch = pool.step(np.full(64, 7))  # blocks the loop, so that nothing is read
                count, _ = await show_frames(page, 400, shown)
                assert shown == [it.tobytes() for it in batch.observations]
                assert count < 400

    run(test())


def test_a_watch_ends_with_its_pool(server: WebServer) -> None:
    async def test() -> None:
        with Client(server.process.address) as client:
            pool = client.create_pool("maze", 1)
            async with open_page(server.url) as page:
                started = await page.call(
                    "watch.start", pool=pool.name, environments=[0], size_px=64
                )
                await page.event("frames")
                pool.close()
                ended = (await page.event("watch_ended")).result
                assert ended["watch"] == started.result["watch"]
                assert ended["code"] == "ABORTED" and pool.name in ended["message"]
                await page.call("watch.stop", watch=ended["watch"])

    run(test())


def test_invalid_watches_are_rejected(server: WebServer) -> None:
    right = {"environments": [0], "size_px": 64}
    wrong: list[tuple[dict[str, Any], str, str]] = [
        ({"environments": []}, "INVALID_ARGUMENT", "is not a list of 1 to 64 integers"),
        ({"environments": [0] * 65}, "INVALID_ARGUMENT", "is not a list of 1 to 64 integers"),
        ({"environments": [-1]}, "INVALID_ARGUMENT", "is not a list of 1 to 64 integers"),
        ({"environments": [2]}, "INVALID_ARGUMENT", "has environments 0 to 1"),
        ({"environments": 0}, "INVALID_ARGUMENT", "is not a list"),
        ({"size_px": 8}, "INVALID_ARGUMENT", "size_px is 8"),
        ({"size_px": 512, "environments": [0, 1] * 16}, "INVALID_ARGUMENT", "at most 21"),
        ({"size_px": 256, "environments": [0, 1] * 11, "format": "rgb"}, "INVALID_ARGUMENT",
         "at most 21 with size_px 256 as rgb"),
        ({"frames_per_second_max": 61}, "INVALID_ARGUMENT", "frames_per_second_max is 61"),
        ({"frames_per_second_max": 0}, "INVALID_ARGUMENT", "frames_per_second_max is 0"),
        ({"format": "jpeg"}, "INVALID_ARGUMENT", "allowed: 'deflate', 'rgb', 'png'"),
        ({"size_px": 65, "format": "deflate"}, "INVALID_ARGUMENT",
         "size_px is 65, allowed with the format deflate: at most 64"),
        ({"pool": "pools/none"}, "NOT_FOUND", "pools/none"),
    ]  # fmt: skip

    async def test() -> None:
        with Client(server.process.address) as client, client.create_pool(
            "maze", 2, rand_seed=1
        ) as pool:
            async with open_page(server.url) as page:
                for members, code, message in wrong:
                    with pytest.raises(PageError) as raised:
                        await page.call("watch.start", **{"pool": pool.name, **right, **members})
                    assert raised.value.code == code, members
                    assert message in raised.value.message, (members, raised.value)
                with pytest.raises(PageError, match="no watch 7"):
                    await page.call("watch.stop", watch=7)
                for _ in range(4):
                    await page.call("watch.start", pool=pool.name, **right)
                with pytest.raises(PageError, match="4 watches, which is the limit"):
                    await page.call("watch.start", pool=pool.name, **right)

    run(test())


def test_an_episode_of_a_running_pool_is_saved_as_a_trace(
    server: WebServer, tmp_path: Path
) -> None:
    async def test() -> None:
        with Client(server.process.address) as client, client.create_pool(
            "coinrun", 3, distribution_mode="easy", rand_seed=5, num_levels=0
        ) as pool:
            rng = np.random.default_rng(1)
            ends: dict[int, list[int]] = {0: [], 1: [], 2: []}
            rewards = []
            while any(len(it) < 2 for it in ends.values()):
                batch = pool.step(rng.integers(0, 15, 3), repeat_count=2)
                rewards.append(batch.rewards.copy())
                for environment in np.flatnonzero(batch.terminated | batch.truncated):
                    ends[environment].append(len(rewards))
            async with open_page(server.url) as page:
                for environment, rows in ends.items():
                    saved = await page.call(
                        "pool.episode", pool=pool.name, environment=environment, selector="last"
                    )
                    assert saved.result["ended"] is True and saved.result["game"] == "coinrun"
                    own = [it[environment] for it in rewards[rows[-2] : rows[-1]]]
                    assert saved.result["total_reward"] == sum(own)
                    trace = saved.parts["trace"]
                    assert conformance(trace, tmp_path).endswith("1 passed, 0 failed, 0 skipped\n")
                    opened = await page.call(
                        "replay.open", pool=pool.name, environment=environment, selector="last",
                        human_size_px=0,
                    )  # fmt: skip
                    assert opened.result["difference"] is None
                    assert opened.result["fingerprint"] == saved.result["fingerprint"]
                    assert opened.result["rows"] == saved.result["steps"] + 1
                current = await page.call(
                    "pool.episode", pool=pool.name, environment=0, selector="current"
                )
                assert current.result["ended"] is False and current.result["fingerprint"] is None
                pool.restore_states(pool.save_states())
                with pytest.raises(PageError, match="the beginning of this episode") as raised:
                    await page.call(
                        "pool.episode", pool=pool.name, environment=0, selector="current"
                    )
                assert raised.value.code == "FAILED_PRECONDITION"

    run(test())


def test_twenty_pages_at_once_see_the_same(server: WebServer, learner: Learner) -> None:
    async def one(number: int) -> int:
        async with open_page(server.url) as page:
            await page.call("pools.follow")
            await page.call(
                "watch.start", pool="pools/learning", environments=list(range(16)), size_px=64
            )
            play = await page.call(
                "play.start", game="maze", mode="easy", level_seed=number, human_size_px=64
            )
            for action in (7, 1, 7, 1):
                view = await page.call("play.step", play=play.result["play"], action=action)
            assert view.result["step"] == 4 and view.result["level_seed"] == number
            await page.event("pools")
            numbers = []
            while len(numbers) < 5:
                frames = await page.event("frames")
                assert len(frames.parts) == 16
                numbers.append(frames.result["request_count"])
            assert numbers == sorted(set(numbers))
            return len(numbers)

    async def test() -> None:
        assert await asyncio.gather(*(one(number) for number in range(20))) == [5] * 20

    run(test())


def test_a_page_that_does_not_read_delays_nothing(server: WebServer, learner: Learner) -> None:
    def resident_bytes() -> int:
        with open(f"/proc/{server.process.process_id}/statm") as numbers:
            return int(numbers.read().split()[1]) * 4096

    async def test() -> None:
        async with open_page(server.url, max_queue=1, read_limit=1024) as slow:
            everything = {"pool": "pools/learning", "environments": list(range(20))}
            for _ in range(4):
                await slow.call("watch.start", **everything, size_px=256, format="rgb")
            await slow.call("pools.follow")
            slow.socket.transport.pause_reading()
            for number in range(1, 40):
                slow.send("gallery.page", game="maze", mode="easy", first_level_seed=number,
                          count=1, size_px=64)  # fmt: skip
            async with open_page(server.url) as other:
                await other.call("watch.start", **everything, size_px=64)
                for _ in range(5):
                    await other.event("frames")
                before = resident_bytes()
                for _ in range(45):
                    await other.event("frames")
                # In three seconds, 15 frame sets a second of 4 x 20 x 196,608 bytes would be 700
                # MB.
                assert resident_bytes() - before < 64 << 20
            slow.socket.transport.abort()

    run(test())
