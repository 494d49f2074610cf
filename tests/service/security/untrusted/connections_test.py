"""Connections that send nothing."""

from __future__ import annotations

import socket
import time
from pathlib import Path

from testbed import Server, serve

_ATTACKER = "127.0.0.2"


def connect(server: Server, source: str) -> socket.socket:
    host, port = server.address.rsplit(":", 1)
    return socket.create_connection((host, int(port)), 10, (source, 0))


def is_closed(connection: socket.socket, timeout: float) -> bool:
    """Whether the server closes the connection within the timeout."""
    end = time.monotonic() + timeout
    while True:
        connection.settimeout(max(end - time.monotonic(), 0.001))
        try:
            if not connection.recv(4096):
                return True
        except TimeoutError:
            return False
        except OSError:
            return True


def test_silent_connections_are_closed(tmp_path: Path) -> None:
    with serve(tmp_path) as server, connect(server, _ATTACKER) as silent:
        assert is_closed(silent, 40)
