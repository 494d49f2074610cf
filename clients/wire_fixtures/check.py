#!/usr/bin/env python3
"""Serves the wire fixtures, and compares a client's requests with the recorded ones.

Usage: clients/wire_fixtures/check.py raw|zstd
Prints `listening on HOST:PORT`. Answers GetCatalog, CreatePool, GetPool, DeletePool and StepPool
with the recorded responses until its standard input ends, then prints the result.
Exit status: 0 all requests came as recorded, 1 not, 2 wrong usage.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from concurrent import futures

import grpc
from script import CATALOG, ENCODINGS, FOLDER, create_pool_request, requests, response_paths

from procgen_client._proto import pools_pb2, step_pb2


def canonical(
    request: step_pb2.StepPoolRequest, env_count: int
) -> step_pb2.StepPoolRequest:
    """Returns a request with defaults filled in, without fields that a client may choose."""
    same = step_pb2.StepPoolRequest()
    same.CopyFrom(request)
    same.acknowledged_sequence_number = 0
    kind = same.WhichOneof("request")
    if kind == "attach":
        same.attach.CopyFrom(step_pb2.Attach(pool=request.attach.pool))
    if kind not in ("step", "reset", "observe"):
        return same
    asked = getattr(same, kind)
    asked.slice.first_env += 0
    asked.slice.env_count = asked.slice.env_count or env_count - asked.slice.first_env
    asked.observation = asked.observation or step_pb2.OBSERVATION_FRAME
    if kind == "step":
        asked.repeat_count = asked.repeat_count or 1
        asked.chunk_count = 0
    return same


class Recorded:
    """The server. `seen`: number of matching requests; `differences`: texts of all others."""

    def __init__(self, encoding: str) -> None:
        self.differences: list[str] = []
        self.seen = 0
        self._encoding = encoding
        self._pool = (FOLDER / encoding / "create_pool.response.bin").read_bytes()

    def services(self) -> list[grpc.GenericRpcHandler]:
        """Returns handlers for grpc.Server that send the bytes of the files unparsed."""
        unary = grpc.unary_unary_rpc_method_handler
        services = {
            "CatalogService": {"GetCatalog": unary(lambda *_: (FOLDER / CATALOG).read_bytes())},
            "PoolService": {
                "CreatePool": unary(self._create_pool),
                "GetPool": unary(lambda *_: self._pool),
                "DeletePool": unary(lambda *_: b""),
            },
            "StepService": {"StepPool": grpc.stream_stream_rpc_method_handler(self._step_pool)},
        }
        return [
            grpc.method_handlers_generic_handler(f"procgen.v1.{name}", methods)
            for name, methods in services.items()
        ]

    def _create_pool(self, message: bytes, _: grpc.ServicerContext) -> bytes:
        given = pools_pb2.CreatePoolRequest.FromString(message).spec
        if given.transport == pools_pb2.TRANSPORT_STREAM:  # The same as none.
            given.ClearField("transport")
        self._compare("CreatePool", given, create_pool_request(self._encoding).spec)
        return self._pool

    def _step_pool(
        self, messages: Iterator[bytes], context: grpc.ServicerContext
    ) -> Iterator[bytes]:
        for message, expected in zip(messages, requests(), strict=False):
            given = step_pb2.StepPoolRequest.FromString(message)
            number = expected.sequence_number
            if not self._compare(f"request {number}", canonical(given, 2), canonical(expected, 2)):
                context.abort(grpc.StatusCode.FAILED_PRECONDITION, self.differences[-1])
            self.seen += 1
            for path in response_paths(self._encoding, number):
                yield path.read_bytes()

    def _compare(self, what: str, given: object, expected: object) -> bool:
        if given != expected:
            self.differences.append(f"{what} is\n{given}and was recorded as\n{expected}")
        return given == expected


def main(arguments: list[str]) -> int:
    """Runs the program."""
    if len(arguments) != 1 or arguments[0] not in ENCODINGS:
        print(__doc__)
        return 2
    recorded = Recorded(arguments[0])
    server = grpc.server(futures.ThreadPoolExecutor(max_workers=4))
    server.add_generic_rpc_handlers(recorded.services())
    print(f"listening on 127.0.0.1:{server.add_insecure_port('127.0.0.1:0')}", flush=True)
    server.start()
    sys.stdin.read()
    server.stop(grace=1).wait()
    for difference in recorded.differences:
        print(difference)
    total = len(requests())
    print(f"{recorded.seen} of {total} requests came as recorded")
    return 0 if recorded.seen == total and not recorded.differences else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
