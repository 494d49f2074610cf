"""A fleet on hosts: nodes and a fleet server, and all that can happen to them."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

from network import Network

# The fleet server's host; the others are called as their nodes.
FLEET = "fleet"
LEARNER = "learner"
_PORT = 50051
_START_TIMEOUT_S = 60.0


class Fleet:
    """Servers by the names of their hosts. Several may be out of order at a time.

    Logs lie in `folder`, one a host.
    """

    def __init__(
        self, network: Network, binary: Path, folder: Path, *, peers: tuple[str, ...] = ()
    ) -> None:
        """Starts nothing.

        Args:
            network: Has the hosts.
            binary: The program procgen-server.
            folder: For logs and for what the fleet server keeps.
            peers: Hosts that find each other without multicast. None: by multicast.
        """
        self._network = network
        self._binary = binary
        self._folder = folder
        self._peers = peers
        self._processes: dict[str, subprocess.Popen[Any]] = {}

    @property
    def address(self) -> str:
        """Where learners reach the fleet server."""
        return self._address(FLEET)

    def log(self, host: str = FLEET) -> str:
        """What its server has logged, over all its lives."""
        path = self._log_path(host)
        return path.read_text() if path.exists() else ""

    def start(self, host: str) -> None:
        """Starts the server of a host, the fleet server on FLEET; it need not be ready yet."""
        flags = [
            f"--address={self._address(host)}",
            "--allow_insecure",
            "--cluster=hosts",
            f"--node_id={host}",
            "--workers=1",
            "--drain_deadline=30s",
            "--shared_memory_folder=",
        ]
        if self._peers:
            addresses = [self._network.address(peer) for peer in self._peers]
            flags.append(f"--cluster_peers={','.join(addresses)}")
        if host == FLEET:
            flags += ["--fleet", f"--state_dir={self._state_folder()}"]
        with open(self._log_path(host), "ab") as log:
            self._processes[host] = self._network.start(
                host, [os.fspath(self._binary), *flags], stdout=log, stderr=log
            )

    def kill(self, host: str) -> None:
        """SIGKILL, and it is gone."""
        self._processes[host].kill()
        self._processes[host].wait()

    def drain(self, host: str) -> None:
        """Tells it to end, once nobody needs it."""
        self._processes[host].terminate()

    def pause(self, host: str) -> None:
        """Stops it as it is, connections and all."""
        self._processes[host].send_signal(signal.SIGSTOP)

    def resume(self, host: str) -> None:
        """Undoes pause."""
        self._processes[host].send_signal(signal.SIGCONT)

    def is_started(self, host: str) -> bool:
        """Whether start was called."""
        return host in self._processes

    def exit_status(self, host: str) -> int | None:
        """How its server ended; None: it runs."""
        return self._processes[host].poll()

    def await_exit(self, host: str, timeout: float) -> int:
        """Waits until it has ended.

        Raises:
            TimeoutExpired: It has not.
        """
        return self._processes[host].wait(timeout)

    def await_log(self, pattern: str, host: str = FLEET, timeout: float = _START_TIMEOUT_S) -> None:
        """Waits until a line of its log has the pattern in it.

        Raises:
            TimeoutError: None had in time, or its server ended.
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
