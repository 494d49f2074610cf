"""Access to pages: tokens, TLS, minimal limits and host names."""

from __future__ import annotations

import asyncio
import http.client
import ssl
import subprocess
from pathlib import Path
from typing import Any

import pytest
import websockets
from bridge_page import Api, CallError, open_bridge
from page import serve

from procgen_client import Credentials, connect

_ALICE, _BOB = "alice-token-0123456789", "bob-token-0123456789"
_UNAUTHENTICATED = 16


def run(test: Any) -> None:
    asyncio.run(test)


@pytest.fixture(scope="module")
def tokens(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("tokens") / "tokens"
    file.write_text(f"alice {_ALICE}\nbob {_BOB}\n")
    file.chmod(0o600)
    return file


def test_pages_and_learners_of_an_owner_share_pools(tokens: Path, tmp_path: Path) -> None:
    async def test(url: str, address: str) -> None:
        with connect(address, credentials=Credentials(token=_BOB)) as bob:
            theirs = bob.create_pool("maze", 1, pool_id="mine")
            async with open_bridge(url, token=_ALICE) as page:
                await page.start_pool("play")
                with connect(address, credentials=Credentials(token=_ALICE)) as alice:
                    assert [pool.owner for pool in alice.list_pools()] == ["alice"]
                assert [it.name for it in bob.list_pools()] == [theirs.name]
            async with open_bridge(url, token=_BOB) as page:
                assert await page.pool_names() == ["pools/mine"]

    with serve(tmp_path, f"--tokens={tokens}") as server:
        run(test(server.url, server.process.address))
        log = server.log_path.read_text()
        assert _ALICE not in log and _BOB not in log


def test_a_removed_token_shows_nothing(tokens: Path, tmp_path: Path) -> None:
    file = tmp_path / "tokens"
    file.write_text(tokens.read_text())

    async def test(url: str) -> None:
        async with open_bridge(url, token=_BOB) as page:
            await page.pool_names()
            file.write_text(f"alice {_ALICE}\n")
            with pytest.raises(CallError) as raised:
                await page.start_pool()
            assert raised.value.code == _UNAUTHENTICATED

    with serve(tmp_path, f"--tokens={file}") as server:
        run(test(server.url))


def test_pages_work_with_minimal_limits(tmp_path: Path) -> None:
    async def test(url: str) -> None:
        async with open_bridge(url) as page:
            play = await page.start_pool()
            for length in range(1, 4):
                await play.send(page.step([7]))
                assert list((await play.read()).batch.episode_lengths) == [length]

    with serve(tmp_path, "--request_bytes_max=65536", "--response_bytes_max=65536") as server:
        run(test(server.url))


def openssl(folder: Path, *arguments: str) -> None:
    subprocess.run(["openssl", *arguments], cwd=folder, check=True, stderr=subprocess.DEVNULL)


@pytest.fixture(scope="module")
def certificate(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("certificate")
    openssl(
        folder, "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes",
        "-days", "2", "-subj", "/CN=server", "-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1",
        "-keyout", "key.pem", "-out", "certificate.pem",
    )  # fmt: skip
    return folder


def test_with_tls_pages_and_sockets_are_secure(
    certificate: Path, tokens: Path, tmp_path: Path
) -> None:
    trusted = ssl.create_default_context(cafile=str(certificate / "certificate.pem"))

    async def test(url: str) -> None:
        assert url.startswith("https://")
        api = Api(url, context=trusted)
        async with open_bridge(url, token=_ALICE, api=api, ssl=trusted) as page:
            play = await page.start_pool(env_count=64)
            await play.send(*(page.step([7] * 64) for _ in range(5)))
            assert [len((await play.read()).batch.observations) for _ in range(5)] == [786432] * 5
        with pytest.raises(websockets.InvalidStatusCode) as raised:
            origin = url.rstrip("/").replace("https", "http")
            async with open_bridge(url, api=api, ssl=trusted, origin=origin):
                pass
        assert raised.value.status_code == 403
        with pytest.raises(ssl.SSLCertVerificationError):
            async with open_bridge(url, api=api, ssl=ssl.create_default_context()):
                pass

    flags = [
        f"--tls_certificate={certificate}/certificate.pem",
        f"--tls_key={certificate}/key.pem",
        f"--tokens={tokens}",
    ]
    with serve(tmp_path, *flags) as server:
        run(test(server.url))
        connection = http.client.HTTPSConnection("localhost", server.port, context=trusted)
        connection.request("GET", "/")
        response = connection.getresponse()
        assert response.status == 200
        assert f"wss://localhost:{server.port};" in response.getheader("Content-Security-Policy")
        connection.close()
        plain = http.client.HTTPConnection("127.0.0.1", server.port)
        with pytest.raises((http.client.HTTPException, ConnectionError)):
            plain.request("GET", "/")
            plain.getresponse()
