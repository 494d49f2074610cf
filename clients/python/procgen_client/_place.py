"""Where a pool runs: in this process, or on a server."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Union

from procgen_client import _library, _structs
from procgen_client.errors import InvalidArgumentError
from procgen_client.tools.art import Art, art_folder

if TYPE_CHECKING:
    from procgen_client.client import Client
    from procgen_client.tools.server_process import ServerProcess

# An address, a connection, or a server that this program started. None: see server_client.
Server = Union[str, "Client", "ServerProcess", None]
# Address of the server of pools that are given none.
SERVER_VARIABLE = "PROCGEN_SERVER"


def server_client(server: Server, art: Art | None) -> tuple[Client | None, Client | None]:
    """Returns the connection of a pool, and the same if the pool has to close it.

    Args:
        server: None: the address in the variable PROCGEN_SERVER. Without it there is no
            connection: the pool is in this process.
        art: Art that was asked for.

    Raises:
        InvalidArgumentError: `art` is given, and there is a server.
        ProcgenError: As Client.
    """
    given = (os.environ.get(SERVER_VARIABLE) or None) if server is None else server
    if given is None:
        return None, None
    address = given if isinstance(given, str) else given.address
    if art is not None:
        raise InvalidArgumentError(
            f"art is {os.fspath(art)}, but the server at {address} chooses its art by its flag "
            "--art_dir: give no server, or ServerProcess(art=...)"
        )
    # The engine in this process needs neither gRPC nor Protocol Buffers.
    from procgen_client.client import Client

    if isinstance(given, Client):
        return given, None
    client = Client(address)
    return client, client


def new_pool(
    client: Client | None,
    games: Sequence[str],
    env_count: int,
    options: Mapping[str, Any],
    art: Art | None,
) -> tuple[Any, Any]:
    """Makes a pool; returns the library that it belongs to, and its handle.

    Args:
        client: The connection to its server. None: in this process.
        games: Names of games.
        env_count: Number of environments.
        options: From options.checked_options.
        art: As for Pool; only in this process.
    """
    if client is not None:
        client._check_open()
        return client._connection.make_pool(games, env_count, options)
    library = _library.library()
    struct, _kept = _structs.pool_options(library, games, env_count, options, art_folder(art))
    handle = ctypes.c_void_p()
    library.check(library.pool_create(ctypes.byref(struct), ctypes.byref(handle)))
    return library, handle
