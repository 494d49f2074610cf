"""The server's log is a full pipe, or a pipe whose reader closed it."""

from __future__ import annotations

import fcntl
import os
import signal
from pathlib import Path

from procgen_client import Client, ServerProcess

# More lines than the pipe and the server's buffer hold. Each pool and its stream give two.
_POOL_COUNT = 1000
_PIPE_BYTES = 4096


def _pipe(folder: Path) -> tuple[Path, int]:
    """Returns a named pipe and its file, open for reading, so that a server can open it."""
    path = folder / "log"
    os.mkfifo(path)
    reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    os.set_blocking(reader, True)
    fcntl.fcntl(reader, fcntl.F_SETPIPE_SZ, _PIPE_BYTES)
    return path, reader


def _make_and_delete_pools(address: str, count: int) -> None:
    with Client(address, timeout=20) as client:
        for _ in range(count):
            client.create_pool("coinrun", 1).close()


def test_a_blocked_log_delays_neither_calls_nor_shutdown(tmp_path: Path) -> None:
    path, reader = _pipe(tmp_path)
    with ServerProcess(flags=["--workers=1", "--log_level=debug"], log_path=path) as server:
        _make_and_delete_pools(server.address, _POOL_COUNT)
        assert server.stop() == 0
    os.close(reader)


def test_the_oldest_waiting_lines_are_dropped(tmp_path: Path) -> None:
    path, reader = _pipe(tmp_path)
    with (
        ServerProcess(flags=["--workers=1", "--log_level=debug"], log_path=path) as server,
        os.fdopen(reader) as log,
    ):
        _make_and_delete_pools(server.address, _POOL_COUNT)
        os.kill(server.process_id, signal.SIGTERM)
        lines = log.read().splitlines()
        assert server.stop() == 0
    assert len(lines) < 2 * _POOL_COUNT
    assert "event=stopped" in lines[-1]


def test_a_closed_log_pipe_is_harmless(tmp_path: Path) -> None:
    path, reader = _pipe(tmp_path)
    with ServerProcess(flags=["--workers=1", "--log_level=debug"], log_path=path) as server:
        os.close(reader)
        _make_and_delete_pools(server.address, 10)
        assert server.stop() == 0
