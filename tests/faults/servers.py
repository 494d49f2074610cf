"""Servers on hosts, and the faults that can be injected."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

from network import Network
from shortage import ThreadLimit, WallClock

_PORT = 50051
_START_TIMEOUT_S = 60.0
# A server that was silent learns that its client has gone by its own keepalive ping, after 40 s.
_FREE_TIMEOUT_S = 60.0


class Servers:
    """Servers by host name, which do not know of each other. Several may have faults at once.

    `folder` contains one log per host.
    """

    def __init__(self, network: Network, binary: Path, folder: Path) -> None:
        """Starts no server yet."""
        self._network = network
        self._binary = binary
        self._folder = folder
        self._processes: dict[str, subprocess.Popen[Any]] = {}
        self._log_begins: dict[str, int] = {}  # Of the running process.
        self._limits: dict[str, ThreadLimit] = {}
        self._clocks: dict[str, WallClock] = {}

    def use_clock(self, host: str, library: Path) -> None:
        """Gives a host a settable wall clock. Call it before its server starts."""
        self._clocks[host] = WallClock(library, self._folder / f"{host}.clock")

    def close(self) -> None:
        """Removes control groups. Call it after the processes have ended."""
        for limit in self._limits.values():
            limit.close()

    def address(self, host: str) -> str:
        """The address of a host's server."""
        return f"{self._network.address(host)}:{_PORT}"

    def log(self, host: str) -> str:
        """The log of a host's server, including earlier processes."""
        path = self._log_path(host)
        return path.read_text() if path.exists() else ""

    def logs(self) -> str:
        """The logs of all servers."""
        return "\n".join(f"{host}:\n{self.log(host)}" for host in self._processes)

    def start(self, host: str) -> None:
        """Starts a host's server without waiting until it is ready."""
        environment = dict(os.environ)
        if host in self._clocks:
            environment.update(self._clocks[host].environment)
        self._log_begins[host] = len(self.log(host))
        with open(self._log_path(host), "ab") as log:
            self._processes[host] = self._network.start(
                host,
                [
                    os.fspath(self._binary),
                    f"--address={self.address(host)}",
                    "--allow_insecure",
                    "--workers=1",
                ],
                stdout=subprocess.DEVNULL,
                stderr=log,
                env=environment,
            )

    def kill(self, host: str) -> None:
        """Sends SIGKILL and waits for the end."""
        self._processes[host].kill()
        self._processes[host].wait()

    def drain(self, host: str) -> None:
        """Sends SIGTERM once the server listens: it drains."""
        self.await_listening(host)
        self._processes[host].terminate()

    def pause(self, host: str) -> None:
        """Sends SIGSTOP; connections stay open."""
        self._processes[host].send_signal(signal.SIGSTOP)

    def resume(self, host: str) -> None:
        """Resumes a paused server."""
        self._processes[host].send_signal(signal.SIGCONT)

    def limit_threads(self, host: str) -> None:
        """Prevents a host's server from starting threads."""
        if host not in self._limits:
            self._limits[host] = ThreadLimit(host)
        self._limits[host].begin(self._processes[host].pid)

    def unlimit_threads(self, host: str) -> None:
        """Undoes limit_threads."""
        self._limits[host].end()

    def set_clock(self, host: str, seconds: int) -> None:
        """Sets a host's wall clock `seconds` ahead of the machine's clock; negative: behind."""
        self._clocks[host].set(seconds)

    def is_running(self, host: str) -> bool:
        """Whether a host's server has not ended."""
        return self._processes[host].poll() is None

    def await_exit(self, host: str, timeout: float) -> int:
        """Waits until a host's server has ended."""
        return self._processes[host].wait(timeout)

    def await_listening(self, host: str) -> None:
        """Waits until a host's server listens."""
        deadline = time.monotonic() + _START_TIMEOUT_S
        while "event=listening" not in self._process_log(host):
            if time.monotonic() > deadline or not self.is_running(host):
                raise TimeoutError(f"{host} does not listen; its log:\n{self.log(host)}")
            time.sleep(0.02)

    def most_pools(self, host: str) -> int:
        """The highest number of pools that a host's server had at once."""
        counts = [0]
        for event in re.findall("event=pool_(created|freed)", self.log(host)):
            counts.append(counts[-1] + (1 if event == "created" else -1))
        return max(counts)

    def await_freed(self) -> None:
        """Waits until no server has a pool."""
        deadline = time.monotonic() + _FREE_TIMEOUT_S
        for host in self._processes:
            while self.is_running(host) and self._pool_count(host) != 0:
                if time.monotonic() > deadline:
                    raise TimeoutError(f"{host} keeps a pool; its log:\n{self.log(host)}")
                time.sleep(0.05)

    def _pool_count(self, host: str) -> int:
        log = self._process_log(host)
        return log.count("event=pool_created") - log.count("event=pool_freed")

    def _process_log(self, host: str) -> str:
        return self.log(host)[self._log_begins[host] :]

    def _log_path(self, host: str) -> Path:
        return self._folder / f"{host}.log"
