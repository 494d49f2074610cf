"""gRPC's own services, health and reflection, which require no token."""

from __future__ import annotations

import contextlib
from pathlib import Path

import grpc
import pytest
from http2 import Http2Connection, message
from testbed import (
    HEALTH_CHECK,
    HEALTH_WATCH,
    LIST_POOLS,
    METADATA,
    REFLECTION,
    Server,
    serve,
)

_SERVING, _NOT_SERVING = 1, 2
_LIST_SERVICES, _FILE_CONTAINING_SYMBOL = 7, 4


def field(number: int, text: str) -> bytes:
    """Encodes a short length-delimited field."""
    return bytes([number << 3 | 2, len(text)]) + text.encode()


def fields(content: bytes) -> list[tuple[int, bytes]]:
    """The length-delimited fields of a message, with their numbers."""
    found, at = [], 0

    def varint() -> int:
        nonlocal at
        value = shift = 0
        while True:
            byte = content[at]
            at += 1
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value

    while at < len(content):
        key = varint()
        size = varint()
        if key & 7 == 2:
            found.append((key >> 3, content[at : at + size]))
            at += size
    return found


def reflect(channel: grpc.Channel, *requests: bytes) -> list[bytes]:
    call = channel.stream_stream(f"/{REFLECTION}", lambda it: it, lambda it: it)
    return list(call(iter(requests), timeout=30))


def check(channel: grpc.Channel, service: str) -> bytes:
    call = channel.unary_unary(f"/{HEALTH_CHECK}", lambda it: it, lambda it: it)
    return call(field(1, service), timeout=30)


@contextlib.contextmanager
def channel_to(server: Server) -> grpc.Channel:
    with grpc.insecure_channel(server.address) as channel:
        yield channel


def test_silent_reflection_streams_take_few_threads(tmp_path: Path) -> None:
    with serve(tmp_path) as server:
        with Http2Connection(server.address) as connection:
            before = server.thread_count()
            silent = [connection.begin(REFLECTION) for _ in range(100)]
            stream = connection.begin(LIST_POOLS, METADATA)
            connection.send(stream, message(b""), ends=True)
            assert connection.trailers(stream)["grpc-status"] == "0"
            assert connection.trailers(silent[-1])["grpc-status"] == "8"
            assert server.thread_count() - before < 10
        with channel_to(server) as channel:
            assert reflect(channel, field(_LIST_SERVICES, ""))


def test_reflection_describes_the_services(tmp_path: Path) -> None:
    with serve(tmp_path) as server, channel_to(server) as channel:
        (answer,) = reflect(channel, field(_LIST_SERVICES, ""))
        (listed,) = [content for number, content in fields(answer) if number == 6]
        names = {fields(service)[0][1].decode() for _, service in fields(listed)}
        own = {f"procgen.v1.{name}Service" for name in ("Catalog", "Cluster", "Pool")}
        assert {name for name in names if not name.startswith("grpc.")} == own
        for name in own:
            (answer,) = reflect(channel, field(_FILE_CONTAINING_SYMBOL, name))
            assert [number for number, _ in fields(answer) if number == 4], name


def test_reflection_does_not_store_unknown_names(tmp_path: Path) -> None:
    # Requests of a million characters each.
    requests = [
        b"\x22\xc0\x84\x3d" + (f"{number:06d}".encode() * 166_667)[:1_000_000]
        for number in range(60)
    ]
    with serve(tmp_path) as server, channel_to(server) as channel:
        reflect(channel, *requests[:5])
        before_mb = server.memory_mb()
        reflect(channel, *requests[5:])
        assert server.memory_mb() - before_mb < 25


def test_health_is_reported_for_each_service(tmp_path: Path) -> None:
    with serve(tmp_path) as server, channel_to(server) as channel:
        for service in ("", "procgen.v1.PoolService"):
            assert check(channel, service) == bytes([8, _SERVING])
        with pytest.raises(grpc.RpcError) as error:
            check(channel, "procgen.v1.Nothing")
        assert error.value.code() == grpc.StatusCode.NOT_FOUND


def test_health_watches_end_with_the_server(tmp_path: Path) -> None:
    with serve(tmp_path) as server, channel_to(server) as channel:
        watch = channel.unary_stream(f"/{HEALTH_WATCH}", lambda it: it, lambda it: it)
        call = watch(b"", timeout=60)
        assert next(call) == bytes([8, _SERVING])
        assert server.process.stop() == 0
        assert next(call) == bytes([8, _NOT_SERVING])
        with pytest.raises(grpc.RpcError):
            next(call)
