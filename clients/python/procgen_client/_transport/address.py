"""Addresses of servers: their form, and whether anything listens at one."""

from __future__ import annotations

import re
import socket

from procgen_client.errors import InvalidArgumentError

_PROBE_TIMEOUT = 0.5  # Seconds.
# gRPC's schemes other than dns, whose targets gRPC checks.
_OTHER_SCHEMES = ("unix:", "unix-abstract:", "vsock:", "ipv4:", "ipv6:", "xds:")
# A name, an IPv4 address, or an IPv6 address in brackets; and a port.
_HOST_PORT = re.compile(r"(?:[^\s:/\[\]]+|\[[0-9A-Fa-f:.%\w]+\]):(\d{1,5})")
_PORT_MAX = 65535


def check_address(address: str) -> None:
    """Raises InvalidArgumentError unless `address` is a host with a port, or of another scheme."""
    if isinstance(address, str) and address.startswith(_OTHER_SCHEMES):
        return
    match = isinstance(address, str) and _HOST_PORT.fullmatch(address.removeprefix("dns:///"))
    if not match or not 1 <= int(match[1]) <= _PORT_MAX:
        raise InvalidArgumentError(
            f"the address is {address!r}; it is host:port (localhost:50051, [::1]:50051) or "
            "unix:PATH"
        )


def dial(address: str) -> socket.socket:
    """Connects a plain socket to `address`, "host:port" or "unix:PATH".

    Raises:
        OSError, ValueError: It cannot be connected, or is of another scheme.
    """
    if not address.startswith("unix:"):
        host, _, port = address.removeprefix("dns:///").rpartition(":")
        return socket.create_connection((host.strip("[]"), int(port)), _PROBE_TIMEOUT)
    line = socket.socket(socket.AF_UNIX)
    try:
        line.settimeout(_PROBE_TIMEOUT)
        line.connect(address.removeprefix("unix:"))
    except BaseException:
        line.close()
        raise
    return line


def why_refused(address: str) -> str:
    """Returns why nothing can be listening at `address`; empty: something may be."""
    try:
        dial(address).close()
    except (ConnectionRefusedError, FileNotFoundError) as error:
        return error.strerror
    except (OSError, ValueError):
        pass
    return ""
