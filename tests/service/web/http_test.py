"""The HTTP port: files, headers, host names and origins."""

from __future__ import annotations

import gzip
import http.client
import socket
from pathlib import Path

import pytest
from page import WebServer, serve


def ask(
    server: WebServer, path: str, method: str = "GET", **headers: str
) -> tuple[http.client.HTTPResponse, bytes]:
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=30)
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    connection.request(method, path, headers=named)
    response = connection.getresponse()
    return response, response.read()


def raw(server: WebServer, request: bytes) -> bytes:
    with socket.create_connection(("127.0.0.1", server.port), timeout=30) as connection:
        connection.sendall(request)
        answer = b""
        while part := connection.recv(65536):
            answer += part
        return answer


def test_pages_have_security_headers(server: WebServer) -> None:
    response, body = ask(server, "/")
    assert response.status == 200
    assert response.getheader("Content-Type") == "text/html; charset=utf-8"
    assert b"<!doctype html>" in body[:100].lower()
    policy = response.getheader("Content-Security-Policy")
    assert "default-src 'none'" in policy and "script-src 'self';" in policy
    assert "unsafe" not in policy
    assert f"connect-src 'self' ws://127.0.0.1:{server.port};" in policy
    assert response.getheader("X-Content-Type-Options") == "nosniff"
    assert response.getheader("Referrer-Policy") == "no-referrer"
    assert response.getheader("X-Frame-Options") == "DENY"


def test_cached_pages_are_not_sent_again(server: WebServer) -> None:
    response, body = ask(server, "/")
    etag = response.getheader("ETag")
    again, nothing = ask(server, "/", If_None_Match=etag)
    assert (again.status, nothing, again.getheader("ETag")) == (304, b"", etag)
    other, same = ask(server, "/", If_None_Match='"other"')
    assert (other.status, same) == (200, body)


def test_files_are_compressed_for_browsers_that_accept_it(server: WebServer) -> None:
    _, body = ask(server, "/")
    for accepted in ("gzip, deflate, br", "br;q=1.0, gzip;q=0.8"):
        response, compressed = ask(server, "/", Accept_Encoding=accepted)
        assert response.getheader("Content-Encoding") == "gzip"
        assert response.getheader("Vary") == "Accept-Encoding"
        assert gzip.decompress(compressed) == body
        assert len(compressed) < len(body) / 2
    for other in ("br", "gzip;q=0", "identity"):
        response, plain = ask(server, "/", Accept_Encoding=other)
        assert response.getheader("Content-Encoding") is None and plain == body


def test_head_returns_only_the_length(server: WebServer) -> None:
    _, body = ask(server, "/")
    response, nothing = ask(server, "/", "HEAD")
    assert (response.status, nothing) == (200, b"")
    assert response.getheader("Content-Length") == str(len(body))


@pytest.mark.parametrize(
    "path",
    ["/nothing", "/index.html", "/assets/", "/assets/../message.cc", "/assets/%2e%2e/message.cc",
     "//", "/../../../etc/passwd", "/assets/index.html/", "/ASSETS/x", "*"],
)  # fmt: skip
def test_other_paths_are_not_found(server: WebServer, path: str) -> None:
    assert ask(server, path)[0].status == 404


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS", "PATCH", "BREW"])
def test_pages_can_only_be_read(server: WebServer, method: str) -> None:
    response, _ = ask(server, "/", method)
    assert response.status == 405 and response.getheader("Allow") == "GET, HEAD"


def test_the_socket_is_no_page(server: WebServer) -> None:
    assert ask(server, "/bridge")[0].status == 426


def test_duplicate_or_missing_host_is_rejected(server: WebServer) -> None:
    for hosts in (b"", b"Host: localhost\r\nHost: localhost\r\n"):
        answer = raw(server, b"GET / HTTP/1.1\r\n" + hosts + b"Connection: close\r\n\r\n")
        assert answer.startswith((b"HTTP/1.1 421", b"HTTP/1.1 400")), answer[:80]


_KEY = b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n"


def upgrade(server: WebServer, host: str, origins: list[str], path: str = "/bridge") -> bytes:
    lines = [f"GET {path} HTTP/1.1", f"Host: {host}", *(f"Origin: {it}" for it in origins)]
    head = "\r\n".join(lines).encode() + b"\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
    with socket.create_connection(("127.0.0.1", server.port), timeout=30) as connection:
        connection.sendall(head + _KEY + b"\r\n")
        return connection.recv(65536)


@pytest.mark.parametrize(
    "origin",
    ["http://evil.example", "null", "https://{host}", "http://{host}.evil.example", "http://{name}",
     "http://user@{host}", "ws://{host}", "{host}"],
)  # fmt: skip
def test_foreign_origins_get_no_socket(server: WebServer, origin: str) -> None:
    host = f"127.0.0.1:{server.port}"
    named = origin.format(host=host, name="127.0.0.1")
    assert upgrade(server, host, [named]).startswith(b"HTTP/1.1 403")


def test_a_socket_needs_an_origin_and_an_allowed_host(server: WebServer) -> None:
    host = f"127.0.0.1:{server.port}"
    assert upgrade(server, host, [f"http://{host}"]).startswith(b"HTTP/1.1 101")
    assert upgrade(server, host, []).startswith(b"HTTP/1.1 403")
    assert upgrade(server, host, [f"http://{host}"] * 2).startswith(b"HTTP/1.1 403")
    # A name that resolves to this server, and a page of that name.
    assert upgrade(server, "evil.example", ["http://evil.example"]).startswith(b"HTTP/1.1 421")
    assert upgrade(server, host, [f"http://{host}"], "/").startswith(b"HTTP/1.1 404")


def test_invalid_requests_are_rejected_and_harmless(server: WebServer) -> None:
    tls = b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(64)
    assert raw(server, tls).startswith(b"HTTP/1.1 400")
    long = b"GET / HTTP/1.1\r\nHost: localhost\r\nX: " + b"x" * 20000 + b"\r\n\r\n"
    assert raw(server, long).startswith(b"HTTP/1.1 400")
    body = b"GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100000\r\n\r\n"
    assert raw(server, body).startswith(b"HTTP/1.1 400")
    assert ask(server, "/")[0].status == 200


def test_one_connection_serves_many_pages(server: WebServer) -> None:
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=30)
    for _ in range(5):
        connection.request("GET", "/")
        response = connection.getresponse()
        assert response.status == 200
        response.read()


def test_allowed_host_names_are_accepted(tmp_path: Path) -> None:
    with serve(tmp_path, "--web_allowed_hosts=lab.example,other.example") as server:
        for host, status in (("LAB.example:80", 200), ("evil.example", 421)):
            assert ask(server, "/", Host=host)[0].status == status
