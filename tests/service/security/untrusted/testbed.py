"""A server that requires tokens, its process resources, and a learner during attacks."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from procgen_client import Client, Credentials, ServerProcess

TOKEN = "alice-token-0123456789"
METADATA = [("authorization", f"Bearer {TOKEN}")]
LIST_POOLS = "procgen.v1.PoolService/ListPools"
GET_POOL = "procgen.v1.PoolService/GetPool"
# At most this part of resident memory under ThreadSanitizer is the program's own.
_OWN_SHARE_MAX = 1 / 6


class Server:
    """A running server."""

    def __init__(self, process: ServerProcess, log_path: Path) -> None:
        self.process = process
        self.address = process.address
        self.log_path = log_path

    def client(self, credentials: Credentials | None = None) -> Client:
        return Client(self.address, credentials=credentials or Credentials(token=TOKEN))

    def memory_mb(self) -> float:
        """Resident memory, without ThreadSanitizer's shadow memory."""
        folder = Path(f"/proc/{self.process.process_id}")
        share = _OWN_SHARE_MAX if "libtsan" in (folder / "maps").read_text() else 1
        for line in (folder / "status").read_text().splitlines():
            if line.startswith("VmRSS:"):
                return int(line.split()[1]) / 1024 * share
        raise AssertionError("no VmRSS")


@contextlib.contextmanager
def serve(folder: Path, *flags: str, address: str = "127.0.0.1:0") -> Iterator[Server]:
    """Runs a server with tokens; expects that it exits with status 0."""
    tokens = folder / "tokens"
    tokens.write_text(f"alice {TOKEN}\n")
    tokens.chmod(0o600)
    log_path = folder / "server.log"
    command = ["--workers=1", f"--tokens={tokens}", "--log_level=debug", *flags]
    with ServerProcess(flags=command, address=address, log_path=log_path) as process:
        yield Server(process, log_path)
        assert process.stop() == 0, log_path.read_text()


class Victim:
    """A learner that steps a pool in a thread and measures each step."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._pool = client.create_pool("maze", 8)
        self._actions = np.full(8, 4, dtype=np.int32)
        self._pool.step(self._actions)
        self.step_s: list[float] = []
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._step_on, daemon=True)
        self._thread.start()

    def _step_on(self) -> None:
        """Steps until stop(), at least once."""
        while True:
            begin = time.monotonic()
            self._pool.step(self._actions)
            self.step_s.append(time.monotonic() - begin)
            if self._stopped.wait(0.002):
                return

    def stop(self) -> list[float]:
        """Stops; returns the durations of its steps in seconds, longest first."""
        self._stopped.set()
        self._thread.join(60)
        assert not self._thread.is_alive(), "the learner's step does not end"
        self._pool.close()
        self._client.close()
        return sorted(self.step_s, reverse=True)


@contextlib.contextmanager
def victim(server: Server, credentials: Credentials | None = None) -> Iterator[Victim]:
    stepping = Victim(server.client(credentials))
    try:
        yield stepping
    finally:
        stepping.stop()
