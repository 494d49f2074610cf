"""Large first requests, and unfinished ones."""

from __future__ import annotations

from pathlib import Path

import grpc
import pytest
from http2 import DATA, HEADERS, Http2Connection, message
from testbed import GET_POOL, METADATA, RUN_POOL, WATCH_POOL, serve

from procgen_client._proto import pools_pb2, run_pb2

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
    start = run_pb2.StartPool(spec=spec)
    request = run_pb2.RunPoolRequest(start=start).SerializeToString()
    assert len(request) > 2_000_000
    own_connection = [("grpc.use_local_subchannel_pool", 1)]
    with serve(tmp_path) as server:
        for _ in range(8):
            with grpc.insecure_channel(server.address, own_connection) as channel:
                run = channel.stream_stream(f"/{RUN_POOL}")
                assert len(list(run(iter([request]), metadata=METADATA, timeout=60))) == 1


def test_unfinished_requests_without_a_token_hold_no_memory(tmp_path: Path) -> None:
    with serve(tmp_path) as server, Http2Connection(server.address) as connection:
        before_mb = server.memory_mb()
        streams = [connection.begin(RUN_POOL) for _ in range(_CALLS)]
        send_unfinished(connection, streams, message(bytes(_REQUEST_BYTES_MAX - 16))[:-1])
        assert server.memory_mb() - before_mb < 40


def test_a_stream_without_a_token_ends_at_its_headers(tmp_path: Path) -> None:
    with serve(tmp_path) as server, Http2Connection(server.address) as connection:
        assert connection.trailers(connection.begin(RUN_POOL))["grpc-status"] == "16"


@pytest.mark.parametrize("method", [GET_POOL, WATCH_POOL])
def test_a_call_that_ends_before_its_request_is_an_error(tmp_path: Path, method: str) -> None:
    with serve(tmp_path) as server, Http2Connection(server.address) as connection:
        stream = connection.begin(method, METADATA)
        connection.send(stream, b"", ends=True)
        assert connection.trailers(stream)["grpc-status"] != "0"
