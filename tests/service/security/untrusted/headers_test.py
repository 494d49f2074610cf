"""Invalid headers beyond the limit of their size (CVE-2023-1428)."""

from __future__ import annotations

from pathlib import Path

import pytest
from http2 import END_HEADERS, END_STREAM, HEADERS, Http2Connection, frame, message, write_headers
from testbed import GET_POOL, LIST_POOLS, METADATA, serve


@pytest.mark.parametrize("name", ["te", ":scheme", "grpclb_client_stats"])
def test_invalid_headers_beyond_the_limit_end_only_their_call(tmp_path: Path, name: str) -> None:
    # gRPC 1.51 may abort. The limit applies once the server's settings are known.
    fields = {
        ":method": "POST", ":scheme": "http", ":path": f"/{GET_POOL}", ":authority": "server",
        "te": "trailers", "content-type": "application/grpc",
    }  # fmt: skip
    block = write_headers([*(fields | {name: "x"}).items(), ("large", "v" * 9_000)])
    with serve(tmp_path) as server, Http2Connection(server.address) as connection:
        stream = connection.begin(LIST_POOLS, METADATA)
        connection.send(stream, message(b""), ends=True)
        assert connection.awaits_end(stream)
        connection.waiting += frame(HEADERS, END_STREAM | END_HEADERS, 3, block)
        assert connection.awaits_end(3)
        with server.client() as client:
            assert client.catalog().games
