"""Standard error is a full pipe, or a pipe whose reader closed it."""

from __future__ import annotations

import fcntl
import os
import socket
import subprocess
from pathlib import Path

import pytest
from testbed import STOP_GRACE_S, run

from procgen_client import Client

_F_SETPIPE_SZ = 1031
# More lines than the pipe and the server's buffer hold. Each pool and its stream give two.
_POOL_COUNT = 1000


def _make_and_delete_pools(address: str, count: int) -> None:
    with Client(address, timeout=20) as client:
        for _ in range(count):
            client.create_pool("coinrun", 1).close()


def _pipe() -> tuple[int, int]:
    """A pipe with a capacity of 4096 bytes."""
    read, write = os.pipe()
    fcntl.fcntl(write, _F_SETPIPE_SZ, 4096)
    return read, write


def test_a_blocked_log_delays_neither_calls_nor_shutdown() -> None:
    read, write = _pipe()
    with run("--workers=1", "--log_level=debug", log=write) as server:
        os.close(write)
        _make_and_delete_pools(server.address, _POOL_COUNT)
        assert server.stop(STOP_GRACE_S) == 0
    os.close(read)


def test_dropped_lines_are_counted_in_the_log() -> None:
    read, write = _pipe()
    with run("--workers=1", "--log_level=debug", log=write) as server, os.fdopen(read) as log:
        os.close(write)
        _make_and_delete_pools(server.address, _POOL_COUNT)
        server.process.terminate()
        lines = log.read().splitlines()
        assert server.process.wait(STOP_GRACE_S) == 0
    dropped = [line for line in lines if "event=log_lines_dropped" in line]
    assert dropped
    count = sum(int(line.rsplit("count=", 1)[1]) for line in dropped)
    written = sum("event=pool_" in line or "event=stream_" in line for line in lines)
    assert 2 * _POOL_COUNT - 20 <= count + written <= 2 * _POOL_COUNT + 20
    assert "event=stopped" in lines[-1]


def test_a_closed_log_pipe_is_harmless() -> None:
    read, write = _pipe()
    with run("--workers=1", "--log_level=debug", log=write) as server:
        os.close(write)
        os.close(read)
        _make_and_delete_pools(server.address, 10)
        assert server.stop(STOP_GRACE_S) == 0


@pytest.fixture
def certificate(tmp_path: Path) -> list[str]:
    """Flags of a server with TLS."""
    command = ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256"]
    command += ["-nodes", "-days", "1", "-subj", "/CN=server", "-keyout", "key", "-out", "cert"]
    subprocess.run(command, cwd=tmp_path, check=True, stderr=subprocess.DEVNULL)
    return [f"--tls_certificate={tmp_path}/cert", f"--tls_key={tmp_path}/key"]


def test_failed_handshakes_do_not_block_on_the_log(
    certificate: list[str],
) -> None:
    read, write = _pipe()
    with run("--workers=1", *certificate, log=write) as server:
        os.close(write)
        host, port = server.address.rsplit(":", 1)
        for _ in range(100):
            with socket.create_connection((host, int(port)), timeout=20) as stranger:
                stranger.sendall(b"GET / HTTP/1.1\r\n\r\n")
                while stranger.recv(4096):
                    pass
        assert server.stop(STOP_GRACE_S) == 0
    os.close(read)
