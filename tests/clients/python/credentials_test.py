"""Tokens, owners, TLS and certificates."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from conftest import server_binary

from procgen_client import (
    Client,
    Credentials,
    Pool,
    ProcgenVectorEnv,
    ServerProcess,
    connect,
    errors,
)

_TOKEN = "alice-token-0123456789"


def _openssl(folder: Path, *arguments: str) -> None:
    subprocess.run(["openssl", *arguments], cwd=folder, check=True, stderr=subprocess.DEVNULL)


def _make_certificate(folder: Path, name: str, subject: str, alternative_names: str) -> None:
    (folder / "extensions").write_text(f"subjectAltName={alternative_names}\n")
    new_key = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes"]
    if not (folder / "authority.pem").exists():
        _openssl(folder, "req", "-x509", *new_key, "-days", "2", "-subj", "/CN=authority",
                 "-keyout", "authority.key", "-out", "authority.pem")  # fmt: skip
    _openssl(folder, "req", *new_key, "-subj", subject, "-keyout", f"{name}.key",
             "-out", "request")  # fmt: skip
    _openssl(folder, "x509", "-req", "-in", "request", "-CA", "authority.pem", "-CAkey",
             "authority.key", "-CAcreateserial", "-days", "1", "-extfile", "extensions",
             "-out", f"{name}.pem")  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with certificates of an authority, a server and a client, and a token file."""
    made = tmp_path_factory.mktemp("credentials")
    _make_certificate(made, "server", "/CN=server", "DNS:localhost,IP:127.0.0.1")
    _make_certificate(made, "elsewhere", "/CN=elsewhere", "DNS:elsewhere.example")
    (made / "other").mkdir()
    _make_certificate(made / "other", "server", "/CN=server", "DNS:localhost,IP:127.0.0.1")
    _make_certificate(made, "alice", "/CN=alice", "URI:spiffe://lab/alice")
    (made / "tokens").write_text(f"alice {_TOKEN}\nbob bob-{_TOKEN}\n")
    return made


@pytest.fixture(scope="module")
def plain(folder: Path) -> Iterator[ServerProcess]:
    """A server with tokens and without TLS."""
    with ServerProcess(server_binary(), ["--workers=1", f"--tokens={folder}/tokens"]) as process:
        yield process


@pytest.fixture(scope="module")
def secure(folder: Path) -> Iterator[ServerProcess]:
    """A server with TLS that requires client certificates."""
    flags = [
        "--workers=1",
        f"--tls_certificate={folder}/server.pem",
        f"--tls_key={folder}/server.key",
        f"--tls_client_ca={folder}/authority.pem",
    ]
    with ServerProcess(server_binary(), flags) as process:
        yield process


def test_token_identifies_the_owner_in_every_call(plain: ServerProcess) -> None:
    with connect(plain.address, credentials=Credentials(token=_TOKEN)) as client:
        with client.create_pool("maze", 2) as pool:
            assert client.list_pools()[0].owner == "alice"
            pool.step([4, 4])
            pool.restore_states(pool.save_states())
            assert len(pool.render([0], size_px=64)) == 1
            with connect(plain.address, credentials=Credentials(token=f"bob-{_TOKEN}")) as other:
                assert other.list_pools() == []
                with pytest.raises(errors.NotFoundError):
                    other.get_pool(pool.name)


def test_token_errors_say_within_a_second_what_to_set(plain: ServerProcess) -> None:
    begun = time.monotonic()
    with pytest.raises(errors.UnauthenticatedError, match="has no token.*set PROCGEN_SERVER_TOKEN"):
        connect(plain.address, credentials=Credentials())
    with pytest.raises(errors.InvalidArgumentError, match="it is the second word"):
        connect(plain.address, credentials=Credentials(token=f"alice {_TOKEN}"))
    assert time.monotonic() - begun < 1


def _tls_flags(folder: Path, name: str) -> list[str]:
    return [
        "--workers=1",
        f"--tls_certificate={folder}/{name}.pem",
        f"--tls_key={folder}/{name}.key",
    ]


@pytest.mark.parametrize(
    ("certificate", "ca", "message"),
    [
        ("server", None, "the server requires TLS: give its CA certificates"),
        (None, "authority.pem", "the server does not use TLS: give no CA certificates"),
        ("server", "other/authority.pem", "certificate is not signed by the given CA"),
        ("elsewhere", "authority.pem", "certificate is for other names: connect by a name"),
    ],
)
def test_wrong_tls_is_explained_within_a_second(
    folder: Path, certificate: str | None, ca: str | None, message: str
) -> None:
    flags = [] if certificate is None else _tls_flags(folder, certificate)
    with ServerProcess(server_binary(), flags) as server:
        credentials = Credentials(ca=None if ca is None else folder / ca)
        begun = time.monotonic()
        with pytest.raises(errors.UnavailableError, match=f"cannot connect to .*{message}"):
            connect(server.address, timeout=30, credentials=credentials)
        assert time.monotonic() - begun < 1


def test_client_that_starts_before_its_server_waits_for_it(folder: Path, tmp_path: Path) -> None:
    address = f"unix:{tmp_path}/socket"
    with ThreadPoolExecutor(1) as threads:
        waiting = threads.submit(connect, address, credentials=Credentials(), timeout=30)
        with pytest.raises(TimeoutError):
            waiting.result(0.5)
        with ServerProcess(server_binary(), ["--workers=1"], address=address):
            waiting.result(30).close()


def test_token_is_read_from_the_environment_variable(
    plain: ServerProcess, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PROCGEN_SERVER_TOKEN", _TOKEN)
    with ProcgenVectorEnv("maze", 1, server=plain.address) as env:
        env.reset()
    monkeypatch.setenv("PROCGEN_SERVER", plain.address)
    with Pool("maze", 1) as pool:
        assert pool.client.list_pools()[0].owner == "alice"


def test_certificates_are_read_from_files_bytes_and_environment(
    secure: ServerProcess, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    files = Credentials(
        ca=folder / "authority.pem", certificate=folder / "alice.pem", key=str(folder / "alice.key")
    )
    contents = Credentials(
        ca=(folder / "authority.pem").read_bytes(),
        certificate=(folder / "alice.pem").read_bytes(),
        key=(folder / "alice.key").read_bytes(),
    )
    monkeypatch.setenv("PROCGEN_SERVER_CA", str(folder / "authority.pem"))
    monkeypatch.setenv("PROCGEN_SERVER_CERTIFICATE", str(folder / "alice.pem"))
    monkeypatch.setenv("PROCGEN_SERVER_KEY", str(folder / "alice.key"))
    for credentials in (files, contents, None):
        with Client(secure.address, credentials=credentials) as client:
            with client.create_pool("maze", 1) as pool:
                assert client.list_pools()[0].owner == "spiffe://lab/alice"
                pool.step([4])


def test_connect_without_the_certificate_is_unavailable(
    secure: ServerProcess, folder: Path
) -> None:
    for credentials in (Credentials(), Credentials(ca=folder / "authority.pem")):
        with pytest.raises(errors.UnavailableError, match="requires? .*(TLS|client certificate)"):
            connect(secure.address, timeout=0.5, credentials=credentials)


def test_token_is_not_sent_to_other_machines_in_plain_text() -> None:
    for address in ("example.com:1", "127.0.0.1.example.com:1", "localhost.x:1", "localhost:1,a:1"):
        with pytest.raises(errors.InvalidArgumentError, match="in plain text") as raised:
            connect(address, credentials=Credentials(token=_TOKEN))
        assert _TOKEN not in str(raised.value)
    for address in ("localhost:1", "127.0.0.1:1", "[::1]:1", "unix:/x", "dns:///localhost:1"):
        with pytest.raises(errors.UnavailableError):
            connect(address, credentials=Credentials(token=_TOKEN), timeout=0.1)


def test_invalid_credentials_are_rejected_and_secrets_are_not_shown(folder: Path) -> None:
    with pytest.raises(errors.InvalidArgumentError, match="alone"):
        connect("localhost:1", credentials=Credentials(ca=b"x", certificate=b"x"))
    with pytest.raises(errors.InvalidArgumentError, match="without the server's CA"):
        connect("localhost:1", credentials=Credentials(certificate=b"x", key=b"x"))
    with pytest.raises(errors.NotFoundError, match="ca is .*none.pem"):
        connect("localhost:1", credentials=Credentials(ca=folder / "none.pem"))
    assert _TOKEN not in repr(Credentials(token=_TOKEN))
