"""The form of addresses of servers."""

from __future__ import annotations

import re

from procgen_client.errors import InvalidArgumentError

# gRPC's schemes other than dns, whose targets gRPC checks.
_OTHER_SCHEMES = ("unix:", "unix-abstract:", "vsock:", "ipv4:", "ipv6:", "xds:")
# A name, an IPv4 address, or an IPv6 address in brackets; and a port.
_HOST_PORT = re.compile(r"(?:[^\s:/\[\]]+|\[[0-9A-Fa-f:.%\w]+\]):(\d{1,5})")
_PORT_MAX = 65535


def check_addresses(addresses: str) -> None:
    """Raises InvalidArgumentError unless `addresses` are valid ones, separated by commas.

    Each may begin with "cluster:".
    """
    for address in addresses.split(",") if isinstance(addresses, str) else [addresses]:
        check_address(address.removeprefix("cluster:") if isinstance(address, str) else address)


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
