"""Floods of frames: calls that are reset, headers that expand, control frames."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from hpack import write_headers
from http2 import (
    CONTINUATION,
    DATA,
    END_HEADERS,
    END_STREAM,
    HEADERS,
    INITIAL_WINDOW_SIZE,
    PING,
    PRIORITY,
    SETTINGS,
    Http2Connection,
    frame,
    message,
)
from testbed import (
    GET_POOL,
    LIST_POOLS,
    METADATA,
    OTHER_METADATA,
    serve,
    victim,
)

_AT_ONCE = 100
_CONTROL_FRAMES = {
    "ping": frame(PING, 0, 0, bytes(8)),
    "settings": frame(SETTINGS, 0, 0, struct.pack(">HI", INITIAL_WINDOW_SIZE, 65535)),
    "priority": frame(PRIORITY, 0, 1, struct.pack(">IB", 0, 15)),
    "empty_data": frame(DATA, 0, 1, b""),
}


def reset_calls(connection: Http2Connection, method: str, count: int, **begin: object) -> int:
    """Starts calls and resets them at once; returns their number when the connection closed."""
    for sent in range(0, count, _AT_ONCE):
        for _ in range(_AT_ONCE):
            connection.reset(connection.begin(method, **begin))  # type: ignore[arg-type]
        connection.flush()
        for _ in connection.frames():
            pass
        if connection.is_closed:
            return sent
    return count


def identify(connection: Http2Connection) -> None:
    """Makes a call with a token."""
    stream = connection.begin(LIST_POOLS, METADATA)
    connection.send(stream, message(b""), ends=True)
    assert connection.trailers(stream)["grpc-status"] == "0"


def send_control_frames(connection: Http2Connection, kind: str, count: int) -> None:
    """Sends `count` frames, or until the connection closes, without reading."""
    for _ in range(0, count, 1000):
        connection.waiting += _CONTROL_FRAMES[kind] * 1000
        connection.flush(timeout=2)
        if connection.is_closed:
            return


def test_reset_calls_of_another_owner_use_bounded_memory(tmp_path: Path) -> None:
    with serve(tmp_path) as server, victim(server) as learner:
        before_mb = server.memory_mb()
        with Http2Connection(server.address) as connection:
            reset_calls(connection, GET_POOL, 20_000, metadata=OTHER_METADATA)
            assert server.memory_mb() - before_mb < 150
        assert learner.stop()[0] < 2.0


def test_metadata_of_a_known_caller_may_be_continued(tmp_path: Path) -> None:
    with serve(tmp_path) as server, Http2Connection(server.address) as connection:
        block = connection.block(GET_POOL, METADATA)
        connection.waiting += frame(HEADERS, 0, 1, block[:20])
        for byte in block[20:-1]:
            connection.waiting += frame(CONTINUATION, 0, 1, bytes([byte]))
        connection.waiting += frame(CONTINUATION, END_HEADERS, 1, block[-1:])
        connection.windows[1] = connection.stream_window
        connection.send(1, b"\0\0\0\0\0", ends=True)
        assert connection.trailers(1)["grpc-status"] == "3"


@pytest.mark.parametrize("name", ["te", ":scheme", "grpclb_client_stats"])
def test_invalid_headers_beyond_the_limit_end_only_their_call(tmp_path: Path, name: str) -> None:
    # CVE-2023-1428: gRPC 1.51 may abort. The limit applies once the server's settings are known.
    fields = {
        ":method": "POST", ":scheme": "http", ":path": f"/{GET_POOL}", ":authority": "server",
        "te": "trailers", "content-type": "application/grpc",
    }  # fmt: skip
    block = write_headers([*(fields | {name: "x"}).items(), ("large", "v" * 9_000)])
    with serve(tmp_path) as server, Http2Connection(server.address) as connection:
        identify(connection)
        connection.waiting += frame(HEADERS, END_STREAM | END_HEADERS, 3, block)
        assert connection.trailers(3)["grpc-status"] == "8"
        with server.client() as client:
            assert client.catalog().games


@pytest.mark.parametrize("kind", _CONTROL_FRAMES)
def test_control_frames_of_a_known_caller_delay_nothing(tmp_path: Path, kind: str) -> None:
    with serve(tmp_path) as server, victim(server) as learner:
        with Http2Connection(server.address) as connection:
            identify(connection)
            before_mb = server.memory_mb()
            send_control_frames(connection, kind, 500_000)
            assert kind != "ping" or connection.awaits_close(20), "too many pings"
            with server.client() as client:
                assert client.catalog().games
            assert server.memory_mb() - before_mb < 150
        assert learner.stop()[0] < 1.0


@pytest.mark.parametrize("metadata", [(), METADATA])
@pytest.mark.parametrize("value_bytes", [127 + 30, 127 + 3750])
def test_headers_that_expand_use_bounded_memory(
    tmp_path: Path, value_bytes: int, metadata: list[tuple[str, str]]
) -> None:
    # Each byte names an entry of HPACK's dynamic table: 16 KiB expand to 47 MB.
    low, high = (value_bytes - 127) & 0x7F, (value_bytes - 127) >> 7
    entry = b"\x40\x01x\x7f" + bytes([low | 0x80, high]) + b"v" * value_bytes
    with serve(tmp_path) as server, victim(server) as learner:
        with Http2Connection(server.address) as connection:
            if metadata:
                identify(connection)
            before_mb, before_s = server.memory_mb(), server.cpu_s()
            for _ in range(50):
                connection.begin(GET_POOL, metadata, block_end=entry + b"\xbe" * 12_000)
            connection.flush()
            connection.awaits_close(2)
            assert server.memory_mb() - before_mb < 150
        assert learner.stop()[0] < 1.0
        assert server.cpu_s() - before_s < 3.0
