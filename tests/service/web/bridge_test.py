"""The bridge: calls of any method of the API over a WebSocket."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
from pathlib import Path
from typing import Any

import pytest
import websockets
from bridge_page import POOLS, Api, BridgePage, CallError, open_bridge
from page import TIMEOUT_S, WebServer, serve

_CATALOG = "/procgen.v1.CatalogService/GetCatalog"
_OK, _CANCELLED, _INVALID_ARGUMENT, _NOT_FOUND = 0, 1, 3, 5
_RESOURCE_EXHAUSTED, _UNIMPLEMENTED, _UNAVAILABLE, _UNAUTHENTICATED = 8, 12, 14, 16
_ALICE = "alice-token-0123456789"


def run(test: Any) -> None:
    asyncio.run(test)


async def wait_until(page: BridgePage, expected: list[str]) -> None:
    """Waits until the pools of a page's owner are those."""
    for _ in range(int(TIMEOUT_S / 0.01)):
        if await page.pool_names() == expected:
            return
        await asyncio.sleep(0.01)
    raise AssertionError(f"pools are {await page.pool_names()}, expected {expected}")


def test_a_unary_call_returns_one_message_and_the_end(server: WebServer) -> None:
    async def test() -> None:
        async with open_bridge(server.url) as page:
            catalog = await page.ask(_CATALOG, page.api.message("GetCatalogRequest"))
            assert len(catalog.games) == 16
            with pytest.raises(CallError, match="there is no pool pools/x") as raised:
                missing = page.api.message("GetPoolRequest", name="pools/x")
                await page.ask(f"{POOLS}GetPool", missing)
            assert raised.value.code == _NOT_FOUND

    run(test())


def test_a_pool_runs_with_several_requests_in_flight(server: WebServer) -> None:
    async def test() -> None:
        async with open_bridge(server.url) as page:
            call = await page.start_pool(env_count=2)
            await call.send(*(page.step([7, 4]) for _ in range(100)))
            await call.half_close()
            lengths = [list((await call.read()).batch.episode_lengths) for _ in range(100)]
            assert lengths[0] == [1, 1]
            assert await call.read() is None
            assert not await page.pool_names()

    run(test())


def test_a_watch_streams_frames_until_it_is_cancelled(server: WebServer) -> None:
    async def test() -> None:
        async with open_bridge(server.url) as page:
            pool = await page.start_pool("watched")
            watch = await page.start(
                f"{POOLS}WatchPool",
                page.api.message("WatchPoolRequest", pool="pools/watched", environments=[0],
                                 size_px=64, frames_per_second_max=60.0),
            )  # fmt: skip
            assert len((await watch.read()).frames[0].image) == 64 * 64 * 3
            await pool.send(page.step([7]))
            assert (await watch.read()).request_count == 1
            await watch.cancel()
            with pytest.raises(CallError) as raised:
                while await watch.read():
                    pass
            assert raised.value.code == _CANCELLED
            # Its number may be used again.
            await page.send(call=watch.number, method=f"{POOLS}ListPools")
            page.calls[watch.number] = watch
            watch.method = f"{POOLS}ListPools"
            await watch.send(b"")
            assert [pool.name for pool in (await watch.read()).pools] == ["pools/watched"]

    run(test())


@pytest.mark.parametrize(
    ("method", "code", "text"),
    [(f"{POOLS}Fly", _UNIMPLEMENTED, ""), ("/nothing", _UNIMPLEMENTED, ""),
     ("procgen.v1.PoolService/ListPools", _INVALID_ARGUMENT, "no path"),
     ("", _INVALID_ARGUMENT, "no path"), ("/a\nb", _INVALID_ARGUMENT, "printable"),
     ("/" + "a" * 256, _INVALID_ARGUMENT, "at most 256")],
)  # fmt: skip
def test_an_unknown_method_ends_its_call(
    server: WebServer, method: str, code: int, text: str
) -> None:
    async def test() -> None:
        async with open_bridge(server.url) as page:
            call = await page.open(method)
            with pytest.raises(CallError, match=text) as raised:
                await call.read()
            assert raised.value.code == code
            await call.send(b"late")  # ignored, as the page may not have known
            assert not await page.pool_names()

    run(test())


def test_garbage_in_a_call_ends_the_call_alone(server: WebServer) -> None:
    async def test() -> None:
        async with open_bridge(server.url) as page:
            call = await page.open(f"{POOLS}RunPool", b"\xff\xff\xff")
            with pytest.raises(CallError, match="not a valid procgen.v1.RunPoolRequest") as raised:
                await call.read()
            assert raised.value.code == _INVALID_ARGUMENT
            assert not await page.pool_names()

    run(test())


@pytest.mark.parametrize(
    ("fields", "text"),
    [({"call": 0, "method": _CATALOG}, "call is 0, allowed: 0 with token, else not 0"),
     ({"call": 3, "token": "x"}, "call is 3, allowed: 0 with token, else not 0"),
     ({"call": 9}, "the request of call 9 is empty"),
     ({"call": 1, "method": _CATALOG}, "call 1 is in use"),
     ({"call": 1, "message": b""}, "call 1 is half-closed")],
)  # fmt: skip
def test_a_request_out_of_place_closes_the_socket(
    server: WebServer, fields: dict[str, Any], text: str
) -> None:
    async def test() -> None:
        async with open_bridge(server.url) as other, open_bridge(server.url) as page:
            await other.start_pool("kept")
            # Stays open after the half-close.
            watched = page.api.message("WatchPoolRequest", pool="pools/kept", environments=[0])
            await page.start(f"{POOLS}WatchPool", watched)
            await page.send(**fields)
            assert await page.closed() == (1008, text)

    run(test())


def test_messages_that_are_no_requests_close_the_socket(server: WebServer) -> None:
    async def test() -> None:
        api = Api(server.url)
        for message, reason in (
            (b"\xff\xff", (1007, "the message is no BridgeRequest")),
            ("text", (1003, "the message is text, allowed: binary")),
            (bytes((4 << 20) + 65), (1009, "")),
        ):
            async with open_bridge(server.url, api=api) as page:
                with contextlib.suppress(websockets.ConnectionClosed):
                    await page.socket.send(message)
                assert await page.closed() == reason

    run(test())


def test_a_request_above_the_limit_ends_its_call(server: WebServer) -> None:
    async def test() -> None:
        async with open_bridge(server.url) as page:
            call = await page.open(f"{POOLS}RunPool", bytes(4 << 20))
            with pytest.raises(CallError) as raised:
                await call.read()
            assert raised.value.code == _INVALID_ARGUMENT

    run(test())


@pytest.fixture(scope="module")
def guarded(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """A server that requires tokens."""
    folder = tmp_path_factory.mktemp("guarded")
    tokens = folder / "tokens"
    tokens.write_text(f"alice {_ALICE}\n")
    tokens.chmod(0o600)
    with serve(folder, f"--tokens={tokens}") as running:
        yield running


@pytest.mark.parametrize("token", [None, "", "stranger-0123456789", "x" * 2049, "a\nb"])
def test_a_wrong_token_is_unauthenticated_and_not_repeated(
    guarded: WebServer, token: str | None
) -> None:
    async def test() -> None:
        async with open_bridge(guarded.url, token=token) as page:
            with pytest.raises(CallError) as raised:
                await page.pool_names()
            expected = _INVALID_ARGUMENT if token in ("a\nb", "x" * 2049) else _UNAUTHENTICATED
            assert raised.value.code == expected
            assert "stranger" not in raised.value.message
            # Another token applies to the calls after it.
            await page.send(token=_ALICE)
            assert await page.pool_names() == []

    run(test())


def test_a_page_without_a_token_is_disconnected(guarded: WebServer) -> None:
    async def test() -> None:
        async with open_bridge(guarded.url) as page:
            # Answered without a token, but not by the API.
            health = await page.start("/grpc.health.v1.Health/Check", b"")
            assert await health.read_bytes() == b"\x08\x01"
            assert await page.closed() == (1008, "no call was answered within 10 seconds")

    run(test())


def test_a_page_that_vanishes_leaves_no_pools(server: WebServer) -> None:
    async def test() -> None:
        async with open_bridge(server.url) as other:
            async with open_bridge(server.url) as page:
                for i in range(3):
                    call = await page.start_pool(f"left-{i}")
                    await call.send(*(page.step([7]) for _ in range(10)))
                assert len(await other.pool_names()) == 3
                page.socket.transport.abort()
            await wait_until(other, [])

    run(test())


def test_a_page_that_does_not_read_skips_frames_and_delays_nobody(server: WebServer) -> None:
    async def test() -> None:
        async with open_bridge(server.url) as slow, open_bridge(server.url) as other:
            pool = await other.start_pool("busy", env_count=16)
            watch = await slow.start(
                f"{POOLS}WatchPool",
                slow.api.message("WatchPoolRequest", pool="pools/busy", environments=range(16),
                                 size_px=256, frames_per_second_max=60.0),
            )  # fmt: skip
            await watch.read()
            slow.socket.transport.pause_reading()
            await asyncio.sleep(0)
            loop = asyncio.get_running_loop()
            end = loop.time() + 3
            count = 0
            while loop.time() < end:
                await pool.send(other.step([7] * 16))
                await pool.read()
                count += 1
            slow.socket.transport.resume_reading()
            # It continues with few old frames, and then the newest.
            frames = 0
            while (await watch.read()).request_count < count:
                frames += 1
            assert frames < 12
            assert count > 100

    run(test())


def test_unread_calls_of_a_page_do_not_block_another(server: WebServer) -> None:
    async def test() -> None:
        async with open_bridge(server.url) as other:
            await other.start_pool("seen", env_count=8)
            async with open_bridge(server.url) as page:
                watches = [
                    await page.start(
                        f"{POOLS}WatchPool",
                        page.api.message("WatchPoolRequest", pool="pools/seen", size_px=256,
                                         environments=range(8)),
                    )
                    for _ in range(20)
                ]  # fmt: skip
                assert await page.pool_names() == ["pools/seen"]
                page.socket.transport.pause_reading()
                for _ in range(20):
                    assert await other.pool_names() == ["pools/seen"]
                page.socket.transport.resume_reading()
                for watch in watches:
                    assert len((await watch.read()).frames) == 8

    run(test())


def test_a_call_beyond_the_limit_ends_at_once(server: WebServer) -> None:
    async def test() -> None:
        async with open_bridge(server.url) as page:
            calls = [await page.open(f"{POOLS}RunPool") for _ in range(64)]
            for _ in range(3):
                one_more = await page.open(_CATALOG, b"")
                with pytest.raises(CallError, match="64 calls in progress") as raised:
                    await one_more.read()
                assert raised.value.code == _RESOURCE_EXHAUSTED
            await calls[0].cancel()
            with pytest.raises(CallError):
                await calls[0].read()
            assert not await page.pool_names()

    run(test())


def test_requests_that_the_server_does_not_take_stop_the_page(server: WebServer) -> None:
    async def test() -> None:
        async with open_bridge(server.url, write_limit=1 << 16) as page:
            async with open_bridge(server.url) as other:
                play = await page.start_pool("stuck")
                request = other.api.message("PausePoolRequest", name="pools/stuck")
                pause = await other.open(f"{POOLS}PausePool", request)
                await pause.read()
                large = page.run("level_sampler", level_seeds=range(100_000))
                sent = 0
                with pytest.raises(asyncio.TimeoutError):
                    while True:
                        await asyncio.wait_for(play.send(large), 2)
                        sent += 1
                # Most of it is in the buffers of TCP.
                assert 1 << 20 < sent * large.ByteSize() < 24 << 20
                await pause.cancel()
                for _ in range(sent):
                    assert (await play.read()).HasField("ack")

    run(test())


def test_an_excess_page_is_rejected_until_another_leaves(tmp_path: Path) -> None:
    async def test(url: str) -> None:
        api = Api(url)
        async with open_bridge(url, api=api), open_bridge(url, api=api):
            async with open_bridge(url, api=api) as third:
                reason = "the server has no room for another page, --web_viewers_max is 2"
                assert await third.closed() == (1013, reason)
        while True:
            try:
                async with open_bridge(url, api=api) as page:
                    await page.pool_names()
                    return
            except (ConnectionError, KeyError, websockets.ConnectionClosed):
                await asyncio.sleep(0.01)

    with serve(tmp_path, "--web_viewers_max=2") as server:
        run(test(server.url))


def test_a_server_that_stops_closes_pages_and_cancels_their_calls(tmp_path: Path) -> None:
    async def test(url: str, stop: Any) -> None:
        async with open_bridge(url) as page, open_bridge(url) as silent:
            pool = await page.start_pool("run")
            await page.start(
                f"{POOLS}WatchPool",
                page.api.message("WatchPoolRequest", pool="pools/run", environments=[0]),
            )
            await silent.start_pool("silent")
            await pool.send(*(page.step([7]) for _ in range(10)))
            silent.socket.transport.pause_reading()
            stop()
            assert await page.closed() == (1001, "the server stops")
            silent.socket.transport.abort()

    with serve(tmp_path) as server:
        run(test(server.url, lambda: os.kill(server.process.process_id, signal.SIGTERM)))
        assert server.process.stop(timeout=9) == 0
