#!/usr/bin/env python3
"""Records the wire fixtures from a real server.

Usage: clients/wire_fixtures/record.py [ADDRESS]
Without ADDRESS it starts a server: PROCGEN_SERVER_BINARY, else procgen-server in PATH.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import grpc
from script import (
    CATALOG,
    ENCODINGS,
    EXPECTED,
    FOLDER,
    create_pool_request,
    expected_values,
    requests,
)

from procgen_client import ServerProcess
from procgen_client._proto import catalog_pb2, pools_pb2, step_pb2
from procgen_client._proto import catalog_pb2_grpc, pools_pb2_grpc, step_pb2_grpc


def play_script(
    channel: grpc.Channel, encoding: str
) -> tuple[pools_pb2.Pool, list[list[step_pb2.StepPoolResponse]]]:
    """Plays the script. Returns the pool, and the responses to each request."""
    pools = pools_pb2_grpc.PoolServiceStub(channel)
    pool = pools.CreatePool(create_pool_request(encoding))
    pool.ClearField("create_time")
    pool.ClearField("expire_time")
    try:
        stream = step_pb2_grpc.StepServiceStub(channel).StepPool(iter(requests()))
        answers: list[list[step_pb2.StepPoolResponse]] = [[] for _ in requests()]
        attached = next(stream)
        attached.attached.pool.ClearField("create_time")
        answers[0].append(attached)
        for response in stream:
            answers[response.sequence_number].append(response)
    finally:
        pools.DeletePool(pools_pb2.DeletePoolRequest(name=pool.name))
    return pool, answers


def record(address: str, folder: Path = FOLDER) -> None:
    """Writes all files."""
    with grpc.insecure_channel(address) as channel:
        catalogs = catalog_pb2_grpc.CatalogServiceStub(channel)
        catalog = catalogs.GetCatalog(catalog_pb2.GetCatalogRequest())
        (folder / CATALOG).write_bytes(catalog.SerializeToString())
        for encoding in ENCODINGS:
            pool, answers = play_script(channel, encoding)
            _write(folder / encoding, pool, answers)
            if encoding == "raw":  # A test holds the others to it.
                expected = list(expected_values(answers))
                (folder / EXPECTED).write_text(json.dumps(expected, indent=1) + "\n")


def _write(
    folder: Path, pool: pools_pb2.Pool, answers: list[list[step_pb2.StepPoolResponse]]
) -> None:
    folder.mkdir(exist_ok=True)
    for old in folder.glob("*.bin"):
        old.unlink()
    request = create_pool_request(folder.name)
    (folder / "create_pool.request.bin").write_bytes(request.SerializeToString())
    (folder / "create_pool.response.bin").write_bytes(pool.SerializeToString())
    for number, (request, answer) in enumerate(zip(requests(), answers, strict=True)):
        (folder / f"{number}.request.bin").write_bytes(request.SerializeToString())
        for part, response in enumerate(answer, start=1):
            path = folder / f"{number}.response-{part}.bin"
            path.write_bytes(response.SerializeToString())


def main(arguments: list[str]) -> int:
    """Runs the program."""
    if len(arguments) > 1 or any(argument.startswith("-") for argument in arguments):
        print(__doc__)
        return 2
    if arguments:
        record(arguments[0])
    else:
        with ServerProcess() as server:
            record(server.address)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
