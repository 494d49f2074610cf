"""Large first requests, and unfinished ones: their memory and their timeouts."""

from __future__ import annotations

from pathlib import Path

import grpc
import pytest
from http2 import DATA, HEADERS, Http2Connection, message
from testbed import CREATE_POOL, GET_POOL, METADATA, WATCH_POOL, serve

from procgen_client._proto import pools_pb2

_REQUEST_BYTES_MAX = 4 << 20
_CALLS = 64


def send_unfinished(connection: Http2Connection, streams: list[int], content: bytes) -> None:
    """Sends content on all streams as far as flow control allows, until nothing is accepted."""
    left = {stream: memoryview(content) for stream in streams}
    fruitless = 0
    while fruitless < 20 and any(left.values()) and not connection.is_closed:
        moved = False
        for stream in streams:
            size = min(connection.room(stream), len(left[stream]))
            if size > 0:
                connection.send(stream, bytes(left[stream][:size]))
                left[stream] = left[stream][size:]
                moved = True
        connection.flush()
        for arrived in connection.frames(0.0 if moved else 0.05):
            if arrived.kind in (DATA, HEADERS):
                left[arrived.stream] = left[arrived.stream][:0]
        fruitless = 0 if moved else fruitless + 1


def test_large_first_requests_of_connections_are_executed(tmp_path: Path) -> None:
    seeds = [seed % 128 for seed in range(400_000)]
    sampler = pools_pb2.LevelSampler(level_seeds=seeds, weights=[1.0] * len(seeds))
    spec = pools_pb2.PoolSpec(games=["coinrun"], env_count=1, level_sampler=sampler)
    request = pools_pb2.CreatePoolRequest(spec=spec).SerializeToString()
    assert len(request) > 2_000_000
    own_connection = [("grpc.use_local_subchannel_pool", 1)]
    with serve(tmp_path) as server:
        for _ in range(8):
            with grpc.insecure_channel(server.address, own_connection) as channel:
                channel.unary_unary(f"/{CREATE_POOL}")(request, metadata=METADATA, timeout=60)


@pytest.mark.parametrize("method", [GET_POOL, WATCH_POOL])
def test_unfinished_requests_without_a_token_hold_no_memory(tmp_path: Path, method: str) -> None:
    with serve(tmp_path) as server, Http2Connection(server.address) as connection:
        before_mb = server.memory_mb()
        streams = [connection.begin(method) for _ in range(_CALLS)]
        send_unfinished(connection, streams, message(bytes(_REQUEST_BYTES_MAX - 16))[:-1])
        assert server.memory_mb() - before_mb < 40


def test_a_call_without_a_token_ends_at_its_headers(tmp_path: Path) -> None:
    with serve(tmp_path) as server, Http2Connection(server.address) as connection:
        for method in (GET_POOL, WATCH_POOL):
            assert connection.trailers(connection.begin(method))["grpc-status"] == "16"


@pytest.mark.parametrize("method", [GET_POOL, WATCH_POOL])
def test_an_unfinished_request_times_out(tmp_path: Path, method: str) -> None:
    with serve(tmp_path, "--attach_timeout=1s") as server:
        with Http2Connection(server.address) as connection:
            stream = connection.begin(method, METADATA)
            connection.send(stream, message(b"half")[:-2])
            trailers = connection.trailers(stream)
    assert trailers["grpc-status"] == "4"
    assert trailers["grpc-message"] == (
        "the request has not arrived within 1s, limit attach_timeout"
    )


@pytest.mark.parametrize("method", [GET_POOL, WATCH_POOL])
def test_a_call_that_ends_before_its_request_is_cancelled(tmp_path: Path, method: str) -> None:
    with serve(tmp_path) as server, Http2Connection(server.address) as connection:
        stream = connection.begin(method, METADATA)
        connection.send(stream, b"", ends=True)
        trailers = connection.trailers(stream)
    assert trailers["grpc-status"] == "1"
    assert trailers["grpc-message"] == "the call ended before its request arrived"
