"""procgen-dm-env-rpc: the sixteen Procgen games for agents that speak dm_env_rpc, version 1.

    procgen-dm-env-rpc                            # environments in this process
    procgen-dm-env-rpc --server localhost:50051   # environments on a Procgen Server

Agents connect to --address, create worlds and join them. Ctrl-C ends the program and its worlds.
It has no authentication: every program that reaches the address can use it.
"""

from __future__ import annotations

import argparse
import ipaddress
import signal
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from procgen_client._place import server_client
from procgen_client.catalog import catalog
from procgen_client.errors import ProcgenError, UnavailableError

DEFAULT_ADDRESS = "127.0.0.1:50061"
# Each stream has a thread.
_STREAM_COUNT_MAX = 256
_SERVICE = "dm_env_rpc.v1.Environment"


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line; returns the exit status, 2 after an error."""
    parser = argparse.ArgumentParser(
        prog="procgen-dm-env-rpc",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--address", default=DEFAULT_ADDRESS, help="where agents connect; default: %(default)s"
    )
    parser.add_argument(
        "--server",
        help="address of a Procgen Server; default: PROCGEN_SERVER, else this process. Credentials "
        "are those of the variables PROCGEN_SERVER_CA, PROCGEN_SERVER_TOKEN and so on",
    )
    given = parser.parse_args(arguments)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        _serve(given.address, given.server)
    except KeyboardInterrupt:
        return 0
    except ImportError as error:
        print(f"procgen-dm-env-rpc: {error}: pip install dm-env-rpc", file=sys.stderr)
    except (ProcgenError, OSError) as error:
        print(f"procgen-dm-env-rpc: {error}", file=sys.stderr)
    return 2


def _serve(address: str, server: str | None) -> None:
    """Serves until KeyboardInterrupt.

    Raises:
        ImportError: grpcio or dm-env-rpc is not installed.
        ProcgenError: `address` cannot be used; or as Client.
        OSError: libprocgen is not installed.
    """
    import grpc

    from procgen_client.dm_env_rpc._session import Session, Worlds

    client, _ = server_client(server, None)
    if client is None:
        catalog()  # Loads the engine.
    worlds = Worlds(client)

    def process(requests: Iterator[bytes], _context: object) -> Iterator[Any]:  # noqa: ANN401
        session = Session(worlds)
        try:
            for request in requests:
                yield session.answer(request)
        finally:
            session.end()

    threads = ThreadPoolExecutor(_STREAM_COUNT_MAX)
    grpc_server = grpc.server(
        threads,
        maximum_concurrent_rpcs=_STREAM_COUNT_MAX,
        options=[("grpc.so_reuseport", 0)],  # An address in use is an error.
    )
    # Requests are parsed by the session, so that invalid ones get an error in the stream.
    handler = grpc.stream_stream_rpc_method_handler(
        process, response_serializer=lambda response: response.SerializeToString()
    )
    grpc_server.add_generic_rpc_handlers(
        (grpc.method_handlers_generic_handler(_SERVICE, {"Process": handler}),)
    )
    try:
        port = grpc_server.add_insecure_port(address)
    except RuntimeError:
        port = 0
    if port == 0:
        raise UnavailableError(f"cannot listen on {address}")
    grpc_server.start()
    try:
        shown = address if address.startswith("unix:") else f"{address.rpartition(':')[0]}:{port}"
        place = "this process" if client is None else f"the server at {client.address}"
        print(f"procgen-dm-env-rpc: serving worlds of {place} on {shown}", flush=True)
        if not _is_local(address):
            print(
                "procgen-dm-env-rpc: warning: other machines can use it without a password",
                file=sys.stderr,
            )
        grpc_server.wait_for_termination()
    finally:
        grpc_server.stop(None).wait()
        threads.shutdown()  # Waits for steps, which outlive their streams.
        worlds.close()
        if client is not None:
            client.close()


def _is_local(address: str) -> bool:
    host = address.rpartition(":")[0].strip("[]")
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost" or address.startswith("unix")


if __name__ == "__main__":
    sys.exit(main())
