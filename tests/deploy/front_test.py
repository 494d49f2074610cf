"""deploy/front: a learner steps through nginx over TLS, and nginx stops floods."""

from __future__ import annotations

import contextlib
import random
import re
import shutil
import socket
import ssl
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import grpc
import numpy as np
import pytest
from http2 import CONTINUATION, HEADERS, Http2Connection, frame, message
from testbed import GET_POOL, TOKEN, Server, serve, victim

from procgen_client import Credentials, errors

_NGINX = shutil.which("nginx") or shutil.which("nginx", path="/usr/sbin")
_CONFIGURATION = Path(__file__).resolve().parents[2] / "deploy" / "front" / "nginx.conf"

pytestmark = pytest.mark.skipif(_NGINX is None, reason="nginx is not installed")


class Front:
    """nginx in front of a server, with certificates of the test's own authority."""

    def __init__(self, folder: Path, server: Server, port: int) -> None:
        self.server = server
        self.address = f"localhost:{port}"
        self._folder = folder

    @property
    def credentials(self) -> Credentials:
        return Credentials(
            ca=(self._folder / "ca.pem").read_bytes(),
            certificate=(self._folder / "client.pem").read_bytes(),
            key=(self._folder / "client.key").read_bytes(),
            token=TOKEN,
        )

    def wrap(self, connection: socket.socket) -> ssl.SSLSocket:
        """Adds TLS with a client certificate to a raw HTTP/2 socket."""
        context = ssl.create_default_context(cafile=str(self._folder / "ca.pem"))
        context.load_cert_chain(self._folder / "client.pem", self._folder / "client.key")
        context.set_alpn_protocols(["h2"])
        return context.wrap_socket(connection, server_hostname="localhost")

    def connection(self) -> Http2Connection:
        return Http2Connection(self.address, wrap=self.wrap)


def make_certificates(folder: Path) -> None:
    def openssl(*arguments: str) -> None:
        subprocess.run(
            ["openssl", *arguments], cwd=folder, check=True, stderr=subprocess.DEVNULL
        )

    new_key = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes")
    openssl("req", "-x509", *new_key, "-days", "2", "-subj", "/CN=authority",
            "-keyout", "ca.key", "-out", "ca.pem")  # fmt: skip
    (folder / "names").write_text("subjectAltName=DNS:localhost")
    for name in ("server", "client"):
        openssl("req", *new_key, "-subj", f"/CN={name}", "-keyout", f"{name}.key",
                "-out", f"{name}.csr")  # fmt: skip
        openssl("x509", "-req", "-in", f"{name}.csr", "-CA", "ca.pem", "-CAkey", "ca.key",
                "-CAcreateserial", "-days", "2", "-extfile", "names",
                "-out", f"{name}.pem")  # fmt: skip


def configure(folder: Path, port: int, server_address: str) -> Path:
    """Copies the configuration of deploy/ with the paths and addresses of this test."""
    text = _CONFIGURATION.read_text()
    for given, here in {
        "listen 443 ssl": f"listen 127.0.0.1:{port} ssl",
        "pid /run/nginx.pid": f"pid {folder}/pid",
        "/var/log/nginx/procgen.log": f"{folder}/front.log",
        "/etc/procgen-server/client-ca.pem": f"{folder}/ca.pem",
        "/etc/procgen-server/": f"{folder}/",
        "127.0.0.1:50051": server_address,
    }.items():
        assert given in text, given
        text = text.replace(given, here)
    path = folder / "nginx.conf"
    path.write_text(text)
    return path


def free_port() -> int:
    """A port that the system gives to no server that listens on port 0 meanwhile."""
    while True:
        port = random.randrange(20000, 30000)
        with contextlib.suppress(OSError), socket.socket() as free:
            free.bind(("127.0.0.1", port))
            return port


@contextlib.contextmanager
def front(folder: Path, *flags: str) -> Iterator[Front]:
    make_certificates(folder)
    port = free_port()
    with serve(folder, *flags) as server:
        configuration = configure(folder, port, server.address)
        command = [str(_NGINX), "-c", str(configuration), "-p", str(folder), "-g", "daemon off;"]
        nginx = subprocess.Popen(command, stderr=subprocess.DEVNULL)
        try:
            for _ in range(500):
                with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port)):
                    break
                assert nginx.poll() is None, (folder / "front.log").read_text()
                time.sleep(0.02)
            yield Front(folder, server, port)
        finally:
            nginx.terminate()
            nginx.wait(30)


@contextlib.contextmanager
def learner_through(running: Front) -> Iterator[object]:
    """A learner that steps through nginx during an attack."""
    there = Server(running.server.process, running.server.log_path)
    there.address = running.address
    with victim(there, running.credentials) as stepping:
        yield stepping


def test_a_learner_steps_through_nginx(tmp_path: Path) -> None:
    with front(tmp_path, "--keepalive_time=1s", "--keepalive_timeout=1s") as running:
        there = Server(running.server.process, running.server.log_path)
        there.address = running.address
        client = there.client(running.credentials)
        with client, client.create_pool("coinrun", 300) as pool:
            for _ in range(5):
                batch = pool.step(np.full(300, 7, dtype=np.int32))
            assert batch.observations.nbytes == 300 * 64 * 64 * 3
            states = pool.save_states()
            time.sleep(3)  # Idle for longer than the keepalive time and timeout.
            pool.step(np.full(300, 4, dtype=np.int32))
            pool.restore_states(states)
            pool.step(np.full(300, 4, dtype=np.int32))
            with pytest.raises(errors.NotFoundError, match="pools/none"):
                client.get_pool("pools/none")


def test_clients_without_a_certificate_are_rejected(tmp_path: Path) -> None:
    with front(tmp_path) as running:
        roots = (tmp_path / "ca.pem").read_bytes()
        with grpc.secure_channel(running.address, grpc.ssl_channel_credentials(roots)) as channel:
            call = channel.unary_unary("/grpc.health.v1.Health/Check")
            with pytest.raises(grpc.RpcError) as error:
                call(b"", timeout=10)
        assert error.value.code() != grpc.StatusCode.OK


def test_reset_calls_end_at_nginx(tmp_path: Path) -> None:
    with front(tmp_path) as running, learner_through(running) as learner:
        before_mb = running.server.memory_mb()
        with running.connection() as connection:
            for _ in range(100):
                for _ in range(100):
                    connection.reset(connection.begin(GET_POOL))
                connection.flush()
                for _ in connection.frames():
                    pass
                if connection.is_closed:
                    break
            assert connection.awaits_close(20)
        assert running.server.memory_mb() - before_mb < 40
        assert learner.stop()[0] < 2.0


def test_endless_headers_end_at_nginx(tmp_path: Path) -> None:
    with front(tmp_path) as running, learner_through(running) as learner:
        with running.connection() as connection:
            block = connection.block(GET_POOL) + b"\0\x03x-a\x7f"
            connection.waiting += frame(HEADERS, 0, 1, block)
            for _ in range(200):
                connection.waiting += frame(CONTINUATION, 0, 1, b"\x80" * 16) * 400
                connection.flush(timeout=5)
                if connection.is_closed:
                    break
            assert connection.awaits_close(20)
        assert learner.stop()[0] < 2.0


def test_unfinished_requests_use_no_memory_behind_nginx(
    tmp_path: Path,
) -> None:
    with front(tmp_path) as running, learner_through(running) as learner:
        before_mb = running.server.memory_mb()
        half = message(bytes(1 << 20))[:-1]
        with running.connection() as connection:
            streams = [connection.begin(GET_POOL) for _ in range(60)]
            for at in range(0, len(half), 16384):
                for stream in streams:
                    if len(half[at : at + 16384]) <= connection.room(stream):
                        connection.send(stream, half[at : at + 16384])
                connection.flush()
                for _ in connection.frames():
                    pass
            assert running.server.memory_mb() - before_mb < 40
        assert learner.stop()[0] < 2.0


def test_the_configuration_is_valid(tmp_path: Path) -> None:
    make_certificates(tmp_path)
    configuration = configure(tmp_path, 1, "127.0.0.1:2")
    command = [str(_NGINX), "-t", "-c", str(configuration), "-p", str(tmp_path)]
    outcome = subprocess.run(command, stderr=subprocess.PIPE, text=True, check=False)
    assert outcome.returncode == 0, outcome.stderr
    assert not re.search(r"\[(warn|emerg)\]", outcome.stderr), outcome.stderr
