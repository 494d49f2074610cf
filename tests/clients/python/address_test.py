"""Addresses of another form, and addresses at which no server listens; a missing library."""

from __future__ import annotations

import socket
import threading

import pytest

from procgen_client import Pool, ProcgenVectorEnv, _library, connect, errors


def test_environments_name_the_wrong_address(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(errors.InvalidArgumentError, match="the address is 'localhost'"):
        ProcgenVectorEnv("maze", 1, server="localhost")
    with pytest.raises(errors.InvalidArgumentError, match="address is 50051; it is text"):
        connect(50051)
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
