"""Access to pages: tokens, owners, quotas, TLS, the limit on viewers, and shutdown."""

from __future__ import annotations

import asyncio
import http.client
import os
import signal
import ssl
import subprocess
from pathlib import Path
from typing import Any

import pytest
import websockets
from page import PageError, open_page, serve

from procgen_client import Client, Credentials, connect, errors

_ALICE, _BOB = "alice-token-0123456789", "bob-token-0123456789"


def run(test: Any) -> None:
    asyncio.run(test)


@pytest.fixture(scope="module")
def tokens(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("tokens") / "tokens"
    file.write_text(f"alice {_ALICE}\nbob {_BOB}\n")
    file.chmod(0o600)
    return file


def test_a_page_sees_only_its_owners_pools(tokens: Path, tmp_path: Path) -> None:
    async def test(url: str, address: str) -> None:
        with connect(address, credentials=Credentials(token=_BOB)) as bob:
            theirs = bob.create_pool("maze", 1, pool_id="mine")
            async with open_page(url, token=_ALICE) as page:
                with connect(address, credentials=Credentials(token=_ALICE)) as alice:
                    await page.call("play.start", game="maze", mode="easy", level_seed=1)
                    (pool,) = alice.list_pools()
                    assert pool.owner == "alice"
                assert [it.name for it in bob.list_pools()] == [theirs.name]
                await page.call("pools.follow")
                pools = (await page.event("pools")).result["pools"]
                assert [(it["owner"], it["kind"]) for it in pools] == [("alice", "play")]
                for method, members in (
                    ("pool.history", {}),
                    ("pool.episodes", {}),
                    ("pool.pause", {}),
                    ("watch.start", {"environments": [0], "size_px": 64}),
                ):
                    with pytest.raises(PageError) as raised:
                        await page.call(method, pool=theirs.name, **members)
                    assert raised.value.code == "NOT_FOUND"
            async with open_page(url, token=_BOB) as page:
                await page.call("pool.history", pool=theirs.name)

    with serve(tmp_path, f"--tokens={tokens}") as server:
        run(test(server.url, server.process.address))
        log = server.log_path.read_text()
        assert _ALICE not in log and _BOB not in log


def test_invalid_tokens_are_rejected(tokens: Path, tmp_path: Path) -> None:
    async def test(url: str) -> None:
        async with open_page(url, says_hello=False) as page:
            for members in ({}, {"token": ""}, {"token": "stranger-0123456789"}):
                with pytest.raises(PageError) as raised:
                    await page.call("hello", **members)
                assert raised.value.code == "UNAUTHENTICATED"
                assert "stranger" not in raised.value.message
                with pytest.raises(PageError, match="hello must come first"):
                    await page.call("pools.follow")
            # The fourth token is valid; the response says that one was required.
            assert (await page.call("hello", token=_ALICE)).result["requires_token"] is True
            await page.call("pools.unfollow")
        async with open_page(url, says_hello=False) as page:
            for _ in range(5):
                with pytest.raises(PageError):
                    await page.call("hello", token="guess-0123456789")
            assert await page.closed() == (1008, "too many tokens that are none")

    with serve(tmp_path, f"--tokens={tokens}") as server:
        run(test(server.url))


def test_a_removed_token_shows_nothing(tokens: Path, tmp_path: Path) -> None:
    file = tmp_path / "tokens"
    file.write_text(tokens.read_text())

    async def test(url: str) -> None:
        async with open_page(url, token=_BOB) as page:
            await page.call("pools.follow")
            await page.event("pools")
            file.write_text(f"alice {_ALICE}\n")
            assert (await page.event("pools_closed")).result["code"] == "UNAUTHENTICATED"
            with pytest.raises(PageError) as raised:
                await page.call("play.start", game="maze", mode="easy", level_seed=1)
            assert raised.value.code == "UNAUTHENTICATED"

    with serve(tmp_path, f"--tokens={file}") as server:
        run(test(server.url))


def test_pages_use_their_owners_quotas(tokens: Path, tmp_path: Path) -> None:
    async def test(url: str) -> None:
        async with open_page(url, token=_ALICE) as page, open_page(url, token=_ALICE) as other:
            await page.call("play.start", game="maze", mode="easy", level_seed=1)
            with pytest.raises(PageError, match="owner_env_count_max") as raised:
                await other.call("play.start", game="maze", mode="easy", level_seed=1)
            assert raised.value.code == "RESOURCE_EXHAUSTED"

    flags = [f"--tokens={tokens}", "--owner_env_count_max=1"]
    with serve(tmp_path, *flags) as server:
        run(test(server.url))


def test_pages_work_with_minimal_limits(tmp_path: Path) -> None:
    async def test(url: str) -> None:
        async with open_page(url) as page:
            level = {"game": "maze", "mode": "easy"}
            view = await page.call("play.start", **level, level_seed=1, human_size_px=0)
            for _ in range(3):
                await page.call("play.step", play=view.result["play"], action=7)
            opened = await page.call("replay.open", play=view.result["play"])
            assert opened.result["difference"] is None
            await page.call("gallery.page", **level, first_level_seed=1, count=2, size_px=64)

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
        async with open_page(url, token=_ALICE, ssl=trusted) as page:
            await page.call("play.start", game="maze", mode="easy", level_seed=1)
        with pytest.raises(websockets.InvalidStatusCode) as raised:
            async with open_page(url, ssl=trusted, origin=url.rstrip("/").replace("https", "http")):
                pass
        assert raised.value.status_code == 403
        with pytest.raises(ssl.SSLCertVerificationError):
            async with open_page(url, ssl=ssl.create_default_context()):
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


def test_an_excess_viewer_is_rejected_until_another_leaves(tmp_path: Path) -> None:
    async def test(url: str) -> None:
        async with open_page(url), open_page(url):
            async with open_page(url, says_hello=False) as third:
                reason = "the server has no room for another page, --web_viewers_max is 2"
                assert await third.closed() == (1013, reason)
        while True:
            try:
                async with open_page(url) as page:
                    await page.call("pools.unfollow")
                    return
            except (ConnectionError, websockets.ConnectionClosed):
                await asyncio.sleep(0.01)

    with serve(tmp_path, "--web_viewers_max=2") as server:
        run(test(server.url))


def test_allowed_host_names_are_accepted(tmp_path: Path) -> None:
    flags = ["--web_allowed_hosts=lab.example,other.example"]
    with serve(tmp_path, *flags) as server:
        for host, status in (("LAB.example:80", 200), ("evil.example", 421)):
            connection = http.client.HTTPConnection("127.0.0.1", server.port)
            connection.request("GET", "/", headers={"Host": host})
            assert connection.getresponse().status == status


def test_shutdown_notifies_pages_and_leaves_nothing(tmp_path: Path) -> None:
    async def test(url: str, stop: Any) -> None:
        async with open_page(url) as one, open_page(url) as two, open_page(url) as silent:
            play = await one.call("play.start", game="maze", mode="easy", level_seed=1)
            await two.call("pools.follow")
            await two.event("pools")
            steps = [one.send("play.step", play=play.result["play"], action=7) for _ in range(10)]
            silent.socket.transport.pause_reading()
            stop()
            for page in (one, two):
                assert "server stops" in (await page.event("draining")).result["message"]
                assert await page.closed() == (1001, "the server stops")
            await asyncio.gather(*steps, return_exceptions=True)
            silent.socket.transport.abort()

    with serve(tmp_path) as server:
        run(test(server.url, lambda: os.kill(server.process.process_id, signal.SIGTERM)))
        # The end of the block checks the server's exit. The pool of a play does not delay the
        # drain.
        assert server.process.stop(timeout=9) == 0
        with pytest.raises(errors.UnavailableError):
            Client(server.process.address)
