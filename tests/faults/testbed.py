"""The testbed of a scenario: servers, and a learner whose trace is compared."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from learner_process import LearnerProcess
from learner_script import Script
from learner_trace import Trace, difference
from network import Network
from servers import Servers

SERVERS = ("a", "b", "c")  # Hosts with a server.
LEARNER = "learner"
# Longer than any fault.
_RECONNECT_TIMEOUT_S = 300.0
# Maximum wait of the learner, for a fault or on a busy machine.
TIMEOUT_S = 300.0

_ROOT = Path(__file__).resolve().parents[2]
_BINARY_VARIABLE = "PROCGEN_SERVER_BINARY"
_CLOCK_VARIABLE = "PROCGEN_WALL_CLOCK_LIBRARY"


def server_binary() -> Path:
    """The path in PROCGEN_SERVER_BINARY, else the newest build of this checkout."""
    if _BINARY_VARIABLE in os.environ:
        return Path(os.environ[_BINARY_VARIABLE])
    built = list(_ROOT.glob("build/*/bin/procgen-server"))
    if not built:
        raise FileNotFoundError(f"no server was built; build it, or set {_BINARY_VARIABLE}")
    return max(built, key=lambda path: path.stat().st_mtime)


def wall_clock_library() -> Path:
    """The path in PROCGEN_WALL_CLOCK_LIBRARY, else the library next to the server."""
    default = server_binary().parents[1] / "tests" / "wall_clock" / "libwall_clock.so"
    library = Path(os.environ.get(_CLOCK_VARIABLE, default))
    if not library.exists():
        raise FileNotFoundError(f"no wall clock at {library}; build the target wall_clock")
    return library


class Testbed:
    """Servers and a learner, each on a host. Leaving the context removes all."""

    __test__ = False  # pytest collects classes whose names begin with Test.

    def __init__(
        self, folder: Path, hosts: Sequence[str] = SERVERS, *, clocks: bool = False
    ) -> None:
        """Starts the servers and waits until they listen."""
        self._folder = folder
        self.hosts = tuple(hosts)
        self.network = Network((*hosts, LEARNER))
        try:
            self.servers = Servers(self.network, server_binary(), folder)
            for host in hosts:
                if clocks:
                    self.servers.use_clock(host, wall_clock_library())
                self.servers.start(host)
            for host in hosts:
                self.servers.await_listening(host)
        except BaseException:
            self._close()
            raise

    def __enter__(self) -> Testbed:
        """Returns the testbed."""
        return self

    def __exit__(self, *exception: object) -> None:
        """Removes the testbed."""
        self._close()

    def _close(self) -> None:
        self.network.close()
        if hasattr(self, "servers"):
            self.servers.close()

    def learner(
        self,
        script: Script,
        *,
        announce: tuple[int, ...] = (),
        reconnect_timeout: float = _RECONNECT_TIMEOUT_S,
    ) -> LearnerProcess:
        """Starts a learner on all servers."""
        return LearnerProcess(
            self.network,
            LEARNER,
            ",".join(self.servers.address(host) for host in self.hosts),
            script,
            self._folder,
            reconnect_timeout=reconnect_timeout,
            announce=announce,
        )


def undisturbed_trace(script: Script, folder: Path) -> Trace:
    """Returns the trace of a learner on one server without faults."""
    (folder / "undisturbed").mkdir()
    with Testbed(folder / "undisturbed", SERVERS[:1]) as testbed:
        return testbed.learner(script).trace(TIMEOUT_S)


def assert_same(expected: Trace, actual: Trace, servers: Servers) -> None:
    """Fails with the servers' logs if the traces differ."""
    found = difference(expected, actual)
    assert found is None, f"{found}\nThe servers' logs:\n{servers.logs()}"
