"""A fleet on hosts: nodes, a fleet server, and the faults that can be injected."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

from network import Network
from shortage import Disk, ThreadLimit, WallClock

# The fleet server's host. Other hosts have the names of their nodes.
FLEET = "fleet"
LEARNER = "learner"
_PORT = 50051
_START_TIMEOUT_S = 60.0


class Fleet:
    """Servers by host name. Several hosts may have faults at once.

    `folder` contains one log per host.
    """

    def __init__(
        self, network: Network, binary: Path, folder: Path, *, peers: tuple[str, ...] = ()
    ) -> None:
        """Starts no server yet.

        Args:
            network: The hosts.
            binary: The program procgen-server.
            folder: The folder for logs and for the fleet server's state.
            peers: The hosts of --cluster_peers. None: discovery by multicast.
        """
        self._network = network
        self._binary = binary
        self._folder = folder
        self._peers = peers
        self._processes: dict[str, subprocess.Popen[Any]] = {}
        self._disk: Disk | None = None
        self._limits: dict[str, ThreadLimit] = {}
        self._clocks: dict[str, WallClock] = {}

    def use_disk(self) -> None:
        """Puts the fleet server's state on a separate disk. Call it before the server starts.

        Raises:
            NotPermittedError: Mounting is not permitted.
        """
        self._disk = Disk(self._state_folder())

    def use_clock(self, host: str, library: Path) -> None:
        """Gives a host a settable wall clock. Call it before its server starts."""
        self._clocks[host] = WallClock(library, self._folder / f"{host}.clock")

    def close(self) -> None:
        """Removes disks and control groups. Call it after the processes have ended."""
        if self._disk is not None:
            self._disk.close()
        for limit in self._limits.values():
            limit.close()

    @property
    def address(self) -> str:
        """The fleet server's address for learners."""
        return self._address(FLEET)

    def log(self, host: str = FLEET) -> str:
        """The log of a host's server, including earlier processes."""
        path = self._log_path(host)
        return path.read_text() if path.exists() else ""

    def start(self, host: str) -> None:
        """Starts a host's server without waiting until it is ready. FLEET runs the fleet server."""
        flags = [
            f"--address={self._address(host)}",
            "--allow_insecure",
            "--cluster=hosts",
            f"--node_id={host}",
            "--workers=1",
            "--drain_timeout=30s",
            "--shared_memory_dir=",
        ]
        if self._peers:
            addresses = [self._network.address(peer) for peer in self._peers]
            flags.append(f"--cluster_peers={','.join(addresses)}")
        if host == FLEET:
            flags += ["--fleet", f"--state_dir={self._state_folder()}"]
        environment = dict(os.environ)
        if host in self._clocks:
            environment.update(self._clocks[host].environment)
        with open(self._log_path(host), "ab") as log:
            self._processes[host] = self._network.start(
                host,
                [os.fspath(self._binary), *flags],
                stdout=log,
                stderr=log,
                env=environment,
            )

    def kill(self, host: str) -> None:
        """Sends SIGKILL and waits for the end."""
        self._processes[host].kill()
        self._processes[host].wait()

    def drain(self, host: str) -> None:
        """Sends SIGTERM: the server drains."""
        self._processes[host].terminate()

    def pause(self, host: str) -> None:
        """Sends SIGSTOP; connections stay open."""
        self._processes[host].send_signal(signal.SIGSTOP)

    def resume(self, host: str) -> None:
        """Resumes a paused server."""
        self._processes[host].send_signal(signal.SIGCONT)

    def fill_disk(self) -> None:
        """Fills the disk of the fleet server's state."""
        assert self._disk is not None
        self._disk.fill()

    def free_disk(self, timeout: float) -> None:
        """Undoes fill_disk, and waits until all pools are durable again.

        Raises:
            TimeoutError: Some pools are not durable.
        """
        assert self._disk is not None
        self._disk.free()
        deadline = time.monotonic() + timeout
        while self.exit_status(FLEET) is None and not self._is_durable():
            if time.monotonic() > deadline:
                raise TimeoutError(f"journals are not written again; the log:\n{self.log()}")
            time.sleep(0.02)

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

    def _is_durable(self) -> bool:
        log = self.log()
        failures = log.count("event=journal_write_failed")
        return log.count("event=journal_write_recovered") >= failures

    def is_started(self, host: str) -> bool:
        """Whether start was called."""
        return host in self._processes

    def exit_status(self, host: str) -> int | None:
        """The exit status of a host's server; None while it runs."""
        return self._processes[host].poll()

    def await_exit(self, host: str, timeout: float) -> int:
        """Waits until a host's server has ended.

        Raises:
            TimeoutExpired: It is still running.
        """
        return self._processes[host].wait(timeout)

    def await_log(self, pattern: str, host: str = FLEET, timeout: float = _START_TIMEOUT_S) -> None:
        """Waits until a line of a host's log matches `pattern`.

        Raises:
            TimeoutError: No line matched in time, or the server ended.
        """
        deadline = time.monotonic() + timeout
        while not re.search(pattern, self.log(host)):
            if time.monotonic() > deadline or self.exit_status(host) is not None:
                raise TimeoutError(f"{host} has not logged {pattern}; it did:\n{self.log(host)}")
            time.sleep(0.02)

    def _address(self, host: str) -> str:
        return f"{self._network.address(host)}:{_PORT}"

    def _log_path(self, host: str) -> Path:
        return self._folder / f"{host}.log"

    def _state_folder(self) -> Path:
        folder = self._folder / "state"
        folder.mkdir(exist_ok=True)
        return folder
