"""Messages of pages: valid requests, invalid ones, and limits."""

from __future__ import annotations

import asyncio
import contextlib
import json
import struct
import time
from typing import Any

import pytest
from page import PageError, WebServer, binary, open_page
from websockets import ConnectionClosed


def run(test: Any) -> None:
    asyncio.run(test)


def test_hello_describes_the_server(server: WebServer) -> None:
    async def test() -> None:
        async with open_page(server.url, says_hello=False) as page:
            hello = (await page.call("hello")).result
        assert hello["requires_token"] is False
        assert hello["version"] and hello["node"].startswith("nodes/")
        games = {game["name"]: game for game in hello["catalog"]["games"]}
        assert len(games) == 16 and "coinrun" in games
        modes = {mode["name"]: mode for mode in games["coinrun"]["modes"]}
        assert modes["easy"]["time_limit_steps"] == 1000
        assert modes["easy"]["return_range"] == {"min": 5, "max": 10}
        assert "level_seed" in modes["exploration"]
        assert games["coinrun"]["special_actions"] == []
        thrown = games["ninja"]["special_actions"]
        assert [special["action"] for special in thrown] == [*range(9, 15)]
        options = {option["name"]: option for option in hello["catalog"]["options"]}
        assert options["use_backgrounds"] == {
            "name": "use_backgrounds", "type": "boolean", "default": True,
            "description": options["use_backgrounds"]["description"],
        }  # fmt: skip
        assert not options.keys() & {"num_levels", "start_level", "rand_seed", "distribution_mode"}
        assert hello["catalog"]["actions"][7] == {"number": 7, "name": "RIGHT", "keys": ["RIGHT"]}
        assert hello["limits"]["viewers"] == 64

    run(test())


# Method, members, expected code, and a part of the expected message.
REFUSALS: list[tuple[str, dict[str, Any], str, str]] = [
    ("nothing", {}, "UNIMPLEMENTED", "there is no method 'nothing'"),
    ("hello", {}, "FAILED_PRECONDITION", "has said hello"),
    ("hello", {"token": 7}, "INVALID_ARGUMENT", "token is 7"),
    ("hello", {"token": "a\nb"}, "INVALID_ARGUMENT", "characters that no token has"),
    ("hello", {"token": "x" * 200}, "INVALID_ARGUMENT", "a text of 200 bytes"),
    ("pools.follow", {"fast": True}, "INVALID_ARGUMENT", "'fast' is no member"),
    ("pools.unfollow", {"pool": "x"}, "INVALID_ARGUMENT", "'pool' is no member"),
    ("pool.history", {}, "INVALID_ARGUMENT", "pool is missing"),
    ("pool.history", {"pool": "maze"}, "INVALID_ARGUMENT", "pools/"),
    ("pool.history", {"pool": "pools/none"}, "NOT_FOUND", "pools/none"),
    ("pool.history", {"pool": ["pools/none"]}, "INVALID_ARGUMENT", "pool is array"),
    ("pool.history", {"pool": "pools/none", "span_s": 90000}, "INVALID_ARGUMENT",
     "span_s is 90000, allowed: integers from 1 to 86400"),
    ("pools.returns", {"pool": "x"}, "INVALID_ARGUMENT", "'pool' is no member"),
    ("pool.episodes", {}, "INVALID_ARGUMENT", "pool is missing"),
    ("pool.episodes", {"pool": "pools/none"}, "NOT_FOUND", "pools/none"),
    ("pool.episodes", {"pool": "pools/none", "after": -1}, "INVALID_ARGUMENT", "after is -1"),
    ("pool.pause", {}, "INVALID_ARGUMENT", "pool is missing"),
    ("pool.pause", {"pool": "pools/none"}, "NOT_FOUND", "pools/none"),
    ("pool.step", {"pool": "pools/none"}, "FAILED_PRECONDITION", "has not paused pool pools/none"),
    ("pool.step", {"pool": "pools/none", "count": 2}, "INVALID_ARGUMENT", "'count' is no member"),
    ("pool.resume", {"pool": 7}, "INVALID_ARGUMENT", "pool is 7"),
    ("pool.episode", {"pool": "pools/none", "environment": 0}, "INVALID_ARGUMENT",
     "selector is missing"),
    ("pool.episode", {"pool": "pools/none", "environment": 0, "selector": "next"},
     "INVALID_ARGUMENT", "selector is 'next', allowed: 'last', 'current'"),
    ("pool.episode", {"pool": "pools/none", "environment": 0, "selector": "last"}, "NOT_FOUND",
     "pools/none"),
    ("pool.episode", {"pool": "pools/none", "environment": 0, "episode": "12"},
     "INVALID_ARGUMENT", "episode is '12', allowed: 16 hexadecimal digits, not all 0"),
    ("pool.episode", {"pool": "pools/none", "environment": 0, "episode": "0" * 16},
     "INVALID_ARGUMENT", "episode is '0000000000000000', allowed: 16 hexadecimal digits"),
    ("pool.episode", {"pool": "pools/none", "environment": 0, "episode": "0123456789abcdef"},
     "NOT_FOUND", "pools/none"),
    ("replay.open", {"pool": "pools/none", "environment": 0, "selector": "last"}, "NOT_FOUND",
     "pools/none"),
    ("play.start", {}, "INVALID_ARGUMENT", "game is missing"),
    ("play.start", {"game": "chess", "mode": "easy", "level_seed": 0}, "INVALID_ARGUMENT",
     "game is 'chess', allowed: 'bigfish'"),
    ("play.start", {"game": "coinrun", "mode": "memory", "level_seed": 0}, "INVALID_ARGUMENT",
     "mode is 'memory', allowed: 'easy'"),
    ("play.start", {"game": "coinrun", "mode": "easy"}, "INVALID_ARGUMENT",
     "level_seed is missing"),
    ("play.start", {"game": "coinrun", "mode": "easy", "level_seed": -1}, "INVALID_ARGUMENT",
     "level_seed is -1, allowed: integers from 0 to 2147483646"),
    ("play.start", {"game": "coinrun", "mode": "easy", "level_seed": 2**63}, "INVALID_ARGUMENT",
     "level_seed is 9223372036854775808"),
    ("play.start", {"game": "coinrun", "mode": "easy", "level_seed": 1.5}, "INVALID_ARGUMENT",
     "level_seed is 1.5"),
    ("play.start", {"game": "coinrun", "mode": "easy", "level_seed": "1"}, "INVALID_ARGUMENT",
     "level_seed is '1'"),
    ("play.start", {"game": "coinrun", "mode": "exploration", "level_seed": 3}, "INVALID_ARGUMENT",
     "level_seed is 3"),
    ("play.start", {"game": "coinrun", "mode": "easy", "level_seed": 0, "human_size_px": 63},
     "INVALID_ARGUMENT", "human_size_px is 63, allowed: 0, or integers from 64 to 1024"),
    ("play.start", {"game": "coinrun", "mode": "easy", "level_seed": 0, "options": []},
     "INVALID_ARGUMENT", "options is array"),
    ("play.start", {"game": "coinrun", "mode": "easy", "level_seed": 0, "options": {"speed": 1}},
     "INVALID_ARGUMENT", "none of the catalog's options"),
    ("play.start", {"game": "coinrun", "mode": "easy", "level_seed": 0,
                    "options": {"num_levels": 1}}, "INVALID_ARGUMENT", "none of the catalog's"),
    ("play.start", {"game": "coinrun", "mode": "easy", "level_seed": 0,
                    "options": {"use_backgrounds": 1}}, "INVALID_ARGUMENT", "is not a boolean"),
    ("play.start", {"game": "coinrun", "mode": "easy", "level_seed": 0,
                    "options": {"debug_mode": 2**40}}, "INVALID_ARGUMENT", "options.debug_mode is"),
    ("play.step", {"play": 1, "action": 7}, "NOT_FOUND", "no play 1"),
    ("play.step", {"play": 1, "action": 15}, "INVALID_ARGUMENT", "integers from 0 to 14"),
    ("play.step", {"play": 1, "action": -1}, "INVALID_ARGUMENT", "action is -1"),
    ("play.step", {"play": True, "action": 1}, "INVALID_ARGUMENT", "play is true"),
    ("play.restart", {"play": 9}, "NOT_FOUND", "no play 9"),
    ("play.next_level", {"play": 9}, "NOT_FOUND", "no play 9"),
    ("play.trace", {"play": None}, "INVALID_ARGUMENT", "play is null"),
    ("play.close", {"play": 9}, "NOT_FOUND", "no play 9"),
    ("replay.open", {}, "INVALID_ARGUMENT", "play is missing"),
    ("replay.open", {"play": 1}, "NOT_FOUND", "no play 1"),
    ("replay.seek", {"replay": 1, "row": 0}, "NOT_FOUND", "no replay 1"),
    ("replay.seek", {"replay": 1, "row": -1}, "INVALID_ARGUMENT", "row is -1"),
    ("replay.seek", {"replay": 1, "row": 0, "map_size_px": 32}, "INVALID_ARGUMENT",
     "map_size_px is 32, allowed: integers from 64 to 1024"),
    ("replay.trace", {"replay": 1}, "NOT_FOUND", "no replay 1"),
    ("replay.close", {"replay": 1}, "NOT_FOUND", "no replay 1"),
    ("gallery.page", {"game": "maze", "mode": "easy", "first_level_seed": 0, "count": 25,
                      "size_px": 64}, "INVALID_ARGUMENT", "count is 25, allowed: integers from 1"),
    ("gallery.page", {"game": "maze", "mode": "easy", "first_level_seed": 2147483646, "count": 2,
                      "size_px": 64}, "INVALID_ARGUMENT", "count is 2"),
    ("gallery.page", {"game": "maze", "mode": "easy", "first_level_seed": 0, "count": 1,
                      "size_px": 2000}, "INVALID_ARGUMENT", "size_px is 2000"),
]  # fmt: skip


def test_invalid_requests_get_errors_and_the_socket_stays_open(server: WebServer) -> None:
    async def test() -> None:
        async with open_page(server.url) as page:
            for method, members, code, message in REFUSALS:
                with pytest.raises(PageError) as raised:
                    await page.call(method, **members)
                assert raised.value.code == code, (method, members, raised.value)
                assert message in raised.value.message, (method, members, raised.value)

    run(test())


def test_hello_comes_first(server: WebServer) -> None:
    async def test() -> None:
        async with open_page(server.url, says_hello=False) as page:
            for method in ("pools.follow", "play.start", "gallery.page"):
                with pytest.raises(PageError, match="hello must come first"):
                    await page.call(method)

    run(test())


_OPEN = {"id": 1, "method": "replay.open"}
# Messages that close the socket, text and binary.
BROKEN: list[str | bytes] = [
    "", "hello", "[]", "7", "{", '{"id": 1}', '{"method": "hello"}',
    '{"id": -1, "method": "hello"}',
    '{"id": "1", "method": "hello"}', '{"id": 1.5, "method": "hello"}', '{"id": 1, "method": 7}',
    '{"id": 99999999999999999999, "method": "hello"}',
    '{"id": 9007199254740993, "method": "hello"}',
    "[" * 1000, '{"a":' * 1000, json.dumps({"id": 1, "method": "x" * 1000}),
    b"", b"\x01", struct.pack("<I", 100) + b"{}", struct.pack("<I", 0xFFFFFFFF) + b"{}",
    struct.pack("<I", 2) + b"{}",
    binary(_OPEN, [{"name": "a", "format": "trace", "bytes": 5}], b"1234"),
    binary(_OPEN, [{"name": "a", "format": "trace", "bytes": 3}], b"1234"),
    binary(_OPEN, [{"name": "a", "format": "trace", "bytes": -1}]),
    binary(_OPEN, [{"name": "a", "format": "trace", "bytes": 2**62}]),
    binary(_OPEN, [{"name": 7, "format": "trace", "bytes": 0}]),
    binary(_OPEN, [{"name": "a", "format": "b", "bytes": 0}] * 5),
    b"\x02\x00\x00\x00\xff\xfe",
]  # fmt: skip


def test_invalid_messages_close_only_their_socket(server: WebServer) -> None:
    async def test() -> None:
        async with open_page(server.url) as other:
            for message in BROKEN:
                async with open_page(server.url) as page:
                    await page.socket.send(message)
                    code, reason = await page.closed()
                    assert code == 1007 and reason, (message[:60], code, reason)
            assert (await other.call("pools.unfollow")).result == {}

    run(test())


def test_messages_are_bounded(server: WebServer) -> None:
    async def test() -> None:
        async with open_page(server.url) as page:
            with contextlib.suppress(ConnectionClosed):  # before everything was sent
                await page.socket.send(b"x" * ((4 << 20) + 1))
            assert (await page.closed())[0] == 1009
        async with open_page(server.url, says_hello=False) as page:
            await page.socket.send("x" * 5000)
            assert (await page.closed())[0] == 1009

    run(test())


def test_only_traces_have_parts(server: WebServer) -> None:
    async def test() -> None:
        async with open_page(server.url) as page:
            with pytest.raises(PageError, match="takes no parts"):
                await page.call("play.close", b"bytes", play=1)

    run(test())


def test_silent_sockets_are_closed(server: WebServer) -> None:
    async def test() -> None:
        async with open_page(server.url, says_hello=False) as page:
            begun = time.monotonic()
            code, reason = await page.closed()
            assert (code, reason) == (1008, "no hello that was accepted within 10 seconds")
            assert time.monotonic() - begun >= 9

    run(test())


def test_requests_beyond_the_rate_wait(server: WebServer) -> None:
    async def test() -> None:
        async with open_page(server.url) as page:
            begun = time.monotonic()
            answers = [page.send("pools.unfollow") for _ in range(400)]
            await asyncio.gather(*answers)
            # The rate limit: a burst of 200, then 100 a second.
            assert time.monotonic() - begun >= 1.8

    run(test())
