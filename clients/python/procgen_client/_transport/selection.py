"""Whether a learner can share memory with its server."""

from __future__ import annotations

import os
import socket
import sys
from typing import TYPE_CHECKING

from procgen_client._proto import catalog_pb2, pools_pb2
from procgen_client._transport import TRANSPORT_VARIABLE, is_native
from procgen_client._warnings import warn_caller
from procgen_client.credentials import is_this_machine
from procgen_client.errors import FailedPreconditionError, ResourceExhaustedError

if TYPE_CHECKING:
    from procgen_client.pool import Pool


def why_streamed(
    address: str, encoding: pools_pb2.Encoding, catalog: catalog_pb2.Catalog
) -> str:
    """Returns why a pool cannot share memory, as far as that is known before it exists.

    Args:
        address: The server's address.
        encoding: Encoding of the pool's observations.
        catalog: The server's catalog.

    Returns:
        The reason. Empty: why_not_mapped decides; the server may run as another user, or at the
        far end of a tunnel.
    """
    if encoding > pools_pb2.ENCODING_RAW:
        return "the observations are encoded; shared memory has raw ones only"
    if not is_native():
        if pools_pb2.TRANSPORT_SHARED_MEMORY in catalog.transports and is_own_address(address):
            _warn_of_missing_module()
        return "this installation has no native module, which shared memory needs"
    if pools_pb2.TRANSPORT_SHARED_MEMORY not in catalog.transports:
        return "the server offers no shared memory"
    if not is_own_address(address):
        return f"the server at {address} is on another machine"
    return ""


_has_warned = False


def _warn_of_missing_module() -> None:
    """Warns once per process, unless there is no such module, or the program chose grpcio."""
    global _has_warned
    if _has_warned or sys.platform != "linux" or TRANSPORT_VARIABLE in os.environ:
        return
    _has_warned = True
    warn_caller(
        "the server is on this machine, but steps go through a socket, several times slower than "
        "through shared memory: the module procgen_client._native is not installed. Build it "
        "(cmake --build build/release --target procgen-python-client), or install the wheel "
        f"(clients/python/build_wheel.sh). {TRANSPORT_VARIABLE}=grpcio turns this warning off",
        RuntimeWarning,
    )


def why_not_mapped(pool: Pool) -> str:
    """Attaches and detaches; returns why the pool's memory cannot be shared, and closes it then."""
    try:
        pool.attach()
        pool.detach()
    except (FailedPreconditionError, ResourceExhaustedError) as error:
        pool.close()
        return error.message
    except BaseException:
        pool.close()
        raise
    return ""


def is_own_address(address: str) -> bool:
    """Whether `address` is loopback, a unix socket, or belongs to an interface of this machine."""
    if is_this_machine(address):
        return True
    host = address.removeprefix("dns:///").rpartition(":")[0].removeprefix("[").removesuffix("]")
    if not host:
        return False
    try:
        found = socket.getaddrinfo(host, 0, type=socket.SOCK_DGRAM)
    except (OSError, UnicodeError):
        return False
    return any(_can_bind(family, sockaddr) for family, *_, sockaddr in found)


def _can_bind(family: int, sockaddr: tuple[object, ...]) -> bool:
    """Whether the address is this machine's: only then a socket can be bound to it."""
    try:
        with socket.socket(family, socket.SOCK_DGRAM) as probe:
            probe.bind(sockaddr)
    except OSError:
        return False
    return True
