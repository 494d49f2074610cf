"""Many TLS handshakes: abandoned ones, and successive complete ones."""

from __future__ import annotations

import contextlib
import socket
import ssl
import subprocess
import threading
import time
from pathlib import Path

import pytest
from testbed import Server, serve, victim

from procgen_client import Credentials

_ATTACKER = "127.0.0.2"
_FLOOD_S = 3.0


@pytest.fixture
def tls(tmp_path: Path) -> list[str]:
    """Flags of a server with a self-signed certificate."""
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj",
         "/CN=localhost", "-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1",
         "-keyout", "server.key", "-out", "server.pem"],
        cwd=tmp_path, check=True, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    return [f"--tls_certificate={tmp_path}/server.pem", f"--tls_key={tmp_path}/server.key"]


def credentials(folder: Path) -> Credentials:
    return Credentials(ca=(folder / "server.pem").read_bytes(), token="alice-token-0123456789")


def connect(server: Server, source: str) -> socket.socket:
    host, port = server.address.rsplit(":", 1)
    return socket.create_connection((host, int(port)), 10, (source, 0))


def client_hello(context: ssl.SSLContext) -> bytes:
    """The first message of a TLS client."""
    incoming, outgoing = ssl.MemoryBIO(), ssl.MemoryBIO()
    tls = context.wrap_bio(incoming, outgoing, server_hostname="localhost")
    with contextlib.suppress(ssl.SSLWantReadError):
        tls.do_handshake()
    return outgoing.read()


def context_of(folder: Path) -> ssl.SSLContext:
    context = ssl.create_default_context(cafile=str(folder / "server.pem"))
    context.set_alpn_protocols(["h2"])
    return context


@pytest.mark.parametrize("part", [0.5, 1.0])
def test_handshakes_that_stall_leave_room_for_others(
    tmp_path: Path, tls: list[str], part: float
) -> None:
    hello = client_hello(context_of(tmp_path))
    with serve(tmp_path, "--connection_count_max=64", *tls) as server:
        before_mb, stalled = server.memory_mb(), []
        for _ in range(100):
            connection = connect(server, _ATTACKER)
            with contextlib.suppress(OSError):
                connection.sendall(hello[: int(len(hello) * part)])
            stalled.append(connection)
        with server.client(credentials(tmp_path)) as client:
            assert client.catalog().games
        assert server.memory_mb() - before_mb < 30
        for connection in stalled:
            connection.close()


def test_successive_handshakes_do_not_block_a_learner(
    tmp_path: Path, tls: list[str]
) -> None:
    context = context_of(tmp_path)
    finished = [0, 0]
    end = threading.Event()

    def flood(server: Server, which: int) -> None:
        while not end.is_set():
            with contextlib.suppress(OSError), connect(server, _ATTACKER) as connection:
                with context.wrap_socket(connection, server_hostname="localhost"):
                    finished[which] += 1

    with serve(tmp_path, *tls) as server, victim(server, credentials(tmp_path)) as learner:
        floods = [threading.Thread(target=flood, args=(server, which)) for which in (0, 1)]
        for thread in floods:
            thread.start()
        time.sleep(_FLOOD_S)  # The duration of the attack.
        end.set()
        for thread in floods:
            thread.join()
        assert sum(finished) > 50
        steps = learner.stop()
        print(f"{sum(finished)} handshakes, {len(steps)} steps, longest {steps[0]:.3f} s")
        assert steps[0] < 1.0
