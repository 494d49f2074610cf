"""Many connections from one address that send nothing or stall."""

from __future__ import annotations

import contextlib
import socket
import time
from pathlib import Path

from http2 import PREFACE, SETTINGS, Http2Connection, frame, message
from testbed import HEALTH_WATCH, LIST_POOLS, METADATA, Server, serve, victim

_ATTACKER, _OTHER = "127.0.0.2", "127.0.0.3"


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


def open_count(connections: list[socket.socket]) -> int:
    return sum(not is_closed(connection, 0.001) for connection in connections)


def test_silent_connections_of_one_address_leave_room_for_others(tmp_path: Path) -> None:
    with serve(tmp_path, "--connection_count_max=64") as server:
        silent = [connect(server, _ATTACKER) for _ in range(100)]
        with Http2Connection(server.address, source=_OTHER) as other:
            stream = other.begin(LIST_POOLS, METADATA)
            other.send(stream, message(b""), ends=True)
            assert other.trailers(stream)["grpc-status"] == "0"
        with server.client() as client:
            assert client.catalog().games
        assert 0 < open_count(silent) <= 8
        for connection in silent:
            connection.close()


def test_known_callers_of_one_address_leave_room_for_others(tmp_path: Path) -> None:
    with serve(tmp_path, "--connection_count_max=64") as server:
        many = []
        for _ in range(60):
            connection = Http2Connection(server.address, source=_ATTACKER)
            stream = connection.begin(LIST_POOLS, METADATA)
            connection.send(stream, message(b""), ends=True)
            if connection.trailers(stream).get("grpc-status") == "0":
                many.append(connection)
        assert len(many) == 32
        with server.client() as client:
            assert client.catalog().games
        for connection in many:
            connection.socket.close()


def test_a_slow_preface_times_out(tmp_path: Path) -> None:
    settings = frame(SETTINGS, 0, 0, b"")
    with serve(tmp_path, "--attach_timeout=1s") as server, victim(server) as learner:
        slow = [connect(server, _ATTACKER) for _ in range(20)]
        end = time.monotonic() + 20
        for byte in (PREFACE + settings * 1000)[: -len(settings)]:
            assert time.monotonic() < end
            for connection in slow:
                with contextlib.suppress(OSError):
                    connection.send(bytes([byte]))
            if all(is_closed(connection, 0.001) for connection in slow):
                break
        else:
            raise AssertionError("they are read to their end")
        assert learner.stop()[0] < 1.0


def test_connections_without_a_token_are_closed(tmp_path: Path) -> None:
    with serve(tmp_path, "--attach_timeout=1s") as server:
        silent = connect(server, _ATTACKER)
        with Http2Connection(server.address) as idle, Http2Connection(server.address) as watching:
            idle.flush()
            stream = watching.begin(HEALTH_WATCH)
            watching.send(stream, message(b""), ends=True)
            watching.flush()
            assert is_closed(silent, 20)
            assert idle.awaits_close(20)
            assert not watching.awaits_close(2), "it has a running call"
        with Http2Connection(server.address) as known:
            stream = known.begin(LIST_POOLS, METADATA)
            known.send(stream, message(b""), ends=True)
            assert known.trailers(stream)["grpc-status"] == "0"
            assert not known.awaits_close(3)
