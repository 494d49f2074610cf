"""Addresses: their form; addresses at which no server listens; a missing library."""

from __future__ import annotations

import socket
import threading
import time

import pytest

from procgen_client import Pool, ProcgenVectorEnv, _library, connect, errors
from procgen_client._address import check_address


@pytest.mark.parametrize(
    "address",
    ["", "localhost", "localhost:", "localhost:0", "localhost:65536", "localhost:http", ":50051",
     "http://localhost:50051", "https://localhost:50051", "grpc://localhost:50051", "::1:50051",
     "::1", "[::1]", "a b:50051", "localhost:50051/", "dns:///localhost", 50051, None],
)  # fmt: skip
def test_address_without_port_or_of_another_form_is_rejected_at_once(address: object) -> None:
    begun = time.monotonic()
    with pytest.raises(errors.InvalidArgumentError, match=r"the address is .*; it is host:port"):
        connect(address)
    assert time.monotonic() - begun < 0.5


@pytest.mark.parametrize(
    "address",
    ["localhost:1", "127.0.0.1:65535", "[::1]:50051", "[fe80::1%eth0]:50051", "a-b.example.com:443",
     "dns:///localhost:1", "unix:/tmp/socket", "unix:socket", "unix-abstract:name", "ipv4:1.2.3.4:5",
     "ipv6:[::1]:5"],
)  # fmt: skip
def test_addresses_of_every_form_are_accepted(address: str) -> None:
    check_address(address)


def test_environments_name_the_wrong_address(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(errors.InvalidArgumentError, match="the address is 'localhost'"):
        ProcgenVectorEnv("maze", 1, server="localhost")
    monkeypatch.setenv("PROCGEN_SERVER", "http://localhost:50051")
    for make in (ProcgenVectorEnv, Pool):
        with pytest.raises(errors.InvalidArgumentError, match="the address is 'http://localhost"):
            make("maze", 1)


def test_peer_that_closes_connections_may_require_tls() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def close_all() -> None:
            while True:
                try:
                    listener.accept()[0].close()
                except OSError:
                    return

        thread = threading.Thread(target=close_all)
        thread.start()
        with pytest.raises(errors.UnavailableError, match="no server answers .*may require TLS"):
            connect(f"127.0.0.1:{listener.getsockname()[1]}", timeout=1)
        listener.shutdown(socket.SHUT_RDWR)
        thread.join()


def test_missing_library_for_servers_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_library, "_remote_library", None)
    monkeypatch.setenv(_library.REMOTE_LIBRARY_VARIABLE, "/no/library")
    expected = r"libprocgen_remote is not installed; tried: /no/library\. .*build_wheel.sh --remote"
    for make in (connect, lambda address: Pool("maze", 1, server=address)):
        with pytest.raises(OSError, match=expected):
            make("localhost:50051")
