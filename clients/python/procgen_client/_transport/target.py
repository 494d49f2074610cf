"""Where a server is, as sockets know it."""

from __future__ import annotations

import os
import re
import socket
from typing import NamedTuple

from procgen_client.credentials import is_this_machine

_PROXY_VARIABLES = ("grpc_proxy", "https_proxy", "http_proxy")
_HOST_AND_PORT = re.compile(
    r"(?:dns:///)?(?:\[(?P<v6>[0-9A-Fa-f:.]+)\]|(?P<name>[\w.-]+)):(?P<port>\d+)"
)


class Target(NamedTuple):
    """A server's address, as sockets know it."""

    path: str | None  # Of a unix socket.
    host: str
    port: int

    @classmethod
    def of(cls, address: str) -> Target | None:
        """Reads an address of gRPC; None: one that grpcio has to find."""
        if address.startswith("unix:"):
            path = address.removeprefix("unix:")
            return cls("/" + path.lstrip("/") if path.startswith("//") else path, "localhost", 0)
        is_behind_proxy = any(os.environ.get(name) for name in _PROXY_VARIABLES)
        match = _HOST_AND_PORT.fullmatch(address)
        if match is None or (is_behind_proxy and not is_this_machine(address)):
            return None
        return cls(None, match["v6"] or match["name"], int(match["port"]))

    @property
    def authority(self) -> str:
        """What requests say of whom they are to."""
        if self.path is not None:
            return self.host
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    def connect(self, timeout: float) -> socket.socket:
        """Opens a connection, for which it waits so many seconds at most.

        Raises:
            OSError: It cannot be had.
        """
        if self.path is not None:
            connection = socket.socket(socket.AF_UNIX)
            try:
                connection.connect(self.path)
            except OSError:
                connection.close()
                raise
        else:
            connection = socket.create_connection((self.host, self.port), timeout)
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            connection.settimeout(None)
        return connection
