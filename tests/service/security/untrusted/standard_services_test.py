"""gRPC's standard services, health and reflection, which require no token."""

from __future__ import annotations

import contextlib
import struct
from pathlib import Path

import grpc
import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
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

_SERVING, _NOT_SERVING, _SERVICE_UNKNOWN = 1, 2, 3
_LIST_SERVICES, _FILE_CONTAINING_SYMBOL = 7, 4
_BOTH = [REFLECTION, REFLECTION.replace("v1alpha", "v1")]


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


def reflect(channel: grpc.Channel, method: str, *requests: bytes) -> list[bytes]:
    call = channel.stream_stream(f"/{method}", lambda it: it, lambda it: it)
    return list(call(iter(requests), timeout=30))


def check(channel: grpc.Channel, service: str) -> int:
    """The status of a service, by a client that gets the health protocol through reflection."""
    request = field(_FILE_CONTAINING_SYMBOL, "grpc.health.v1.Health")
    (answer,) = reflect(channel, REFLECTION, request)
    pool = descriptor_pool.DescriptorPool()
    for number, response in fields(answer):
        if number == 4:
            for _, file in fields(response):
                pool.Add(descriptor_pb2.FileDescriptorProto.FromString(file))
    method = pool.FindServiceByName("grpc.health.v1.Health").FindMethodByName("Check")
    factory = message_factory.MessageFactory(pool)
    request, response = map(factory.GetPrototype, (method.input_type, method.output_type))
    call = channel.unary_unary(
        "/grpc.health.v1.Health/Check", request.SerializeToString, response.FromString
    )
    return int(call(request(service=service), timeout=30).status)


@contextlib.contextmanager
def channel_to(server: Server) -> grpc.Channel:
    with grpc.insecure_channel(server.address) as channel:
        yield channel


def test_silent_reflection_streams_take_no_threads(tmp_path: Path) -> None:
    with serve(tmp_path) as server, Http2Connection(server.address) as connection:
        before = server.thread_count()
        for _ in range(100):
            connection.begin(REFLECTION)
        stream = connection.begin(LIST_POOLS, METADATA)
        connection.send(stream, message(b""), ends=True)
        assert connection.trailers(stream)["grpc-status"] == "0"
        assert server.thread_count() - before < 10


def test_a_silent_reflection_stream_ends(tmp_path: Path) -> None:
    with serve(tmp_path, "--attach_timeout=1s") as server:
        with Http2Connection(server.address) as connection:
            trailers = connection.trailers(connection.begin(REFLECTION))
    assert trailers["grpc-status"] == "4"
    assert trailers["grpc-message"] == "the stream has not ended within 1s, limit attach_timeout"


def test_unread_reflection_streams_end(tmp_path: Path) -> None:
    with serve(tmp_path, "--attach_timeout=1s") as server:
        with Http2Connection(server.address) as connection:
            connection.waiting = connection.waiting.replace(
                struct.pack(">HI", 4, 1 << 24), struct.pack(">HI", 4, 0)
            )
            stream = connection.begin(REFLECTION)
            connection.send(stream, message(field(_LIST_SERVICES, "")))
            assert connection.trailers(stream)["grpc-status"] == "1"


@pytest.mark.parametrize("method", _BOTH)
def test_reflection_describes_all_services_that_it_lists(tmp_path: Path, method: str) -> None:
    with serve(tmp_path) as server, channel_to(server) as channel:
        (answer,) = reflect(channel, method, field(_LIST_SERVICES, ""))
        (listed,) = [content for number, content in fields(answer) if number == 6]
        names = [fields(service)[0][1].decode() for _, service in fields(listed)]
        assert {"grpc.health.v1.Health", "dm_env_rpc.v1.Environment"} < set(names)
        assert "procgen.v1.StepService" in names
        for name in names:
            (answer,) = reflect(channel, method, field(_FILE_CONTAINING_SYMBOL, name))
            assert [number for number, _ in fields(answer) if number == 4], name


@pytest.mark.parametrize("symbol", ["nothing", "procgen.v1.Nothing", "procgen", ""])
def test_reflection_reports_unknown_names(tmp_path: Path, symbol: str) -> None:
    with serve(tmp_path) as server, channel_to(server) as channel:
        (answer,) = reflect(channel, REFLECTION, field(_FILE_CONTAINING_SYMBOL, symbol))
    assert b"this server has no such descriptor" in answer


def test_reflection_does_not_store_unknown_names(tmp_path: Path) -> None:
    # Requests of a million characters each.
    requests = [
        b"\x22\xc0\x84\x3d" + (f"{number:06d}".encode() * 166_667)[:1_000_000]
        for number in range(60)
    ]
    with serve(tmp_path) as server, channel_to(server) as channel:
        reflect(channel, REFLECTION, *requests[:5])
        before_mb = server.memory_mb()
        reflect(channel, REFLECTION, *requests[5:])
        assert server.memory_mb() - before_mb < 25


def test_generic_clients_can_ask_for_the_health_of_all_services(tmp_path: Path) -> None:
    with serve(tmp_path) as server, channel_to(server) as channel:
        for service in ("", "procgen.v1.StepService", "dm_env_rpc.v1.Environment"):
            assert check(channel, service) == _SERVING
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
        with pytest.raises(grpc.RpcError) as error:
            next(call)
        assert error.value.details() == "the server stops"


def test_health_reports_unknown_services(tmp_path: Path) -> None:
    with serve(tmp_path) as server, channel_to(server) as channel:
        watch = channel.unary_stream(f"/{HEALTH_WATCH}", lambda it: it, lambda it: it)
        call = watch(field(1, "procgen.v1.Nothing"), timeout=60)
        assert next(call) == bytes([8, _SERVICE_UNKNOWN])
        call.cancel()
        with pytest.raises(grpc.RpcError) as error:
            channel.unary_unary(f"/{HEALTH_CHECK}", lambda it: it, lambda it: it)(
                b"\x0a\xac\x02" + b"x" * 300, timeout=30
            )
        assert error.value.details() == "service has 300 characters, allowed: at most 256"
