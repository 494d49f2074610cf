"""The testbed of a scenario: hosts, a fleet, and a learner whose trace is compared."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Mapping
from pathlib import Path
from types import TracebackType

from fleet import FLEET, LEARNER, Fleet
from learner_process import LearnerProcess
from learner_script import Script
from learner_trace import Trace, difference
from network import Network

NODES = ("a", "b", "c")
SPARE = "d"  # A host without a node at first.
# Maximum wait of the learner, for a fault or on a busy machine.
TIMEOUT_S = 300.0

_ROOT = Path(__file__).resolve().parents[2]
_BINARY_VARIABLE = "PROCGEN_SERVER_BINARY"
_CLOCK_VARIABLE = "PROCGEN_WALL_CLOCK_LIBRARY"


def server_binary() -> Path:
    """The path in PROCGEN_SERVER_BINARY, else the newest build of this checkout.

    Raises:
        FileNotFoundError: There is no build.
    """
    if _BINARY_VARIABLE in os.environ:
        return Path(os.environ[_BINARY_VARIABLE])
    built = list(_ROOT.glob("build/*/bin/procgen-server"))
    if not built:
        raise FileNotFoundError(f"no server was built; build it, or set {_BINARY_VARIABLE}")
    return max(built, key=lambda path: path.stat().st_mtime)


def wall_clock_library() -> Path:
    """The path in PROCGEN_WALL_CLOCK_LIBRARY, else the library next to the server.

    Raises:
        FileNotFoundError: The library was not built.
    """
    default = server_binary().parents[1] / "tests" / "wall_clock" / "libwall_clock.so"
    library = Path(os.environ.get(_CLOCK_VARIABLE, default))
    if not library.exists():
        raise FileNotFoundError(f"no wall clock at {library}; build the target wall_clock")
    return library


class Testbed:
    """Three nodes, a fleet server, a learner and a spare host. Leaving the context removes all.

    Attributes:
        network: The hosts.
        fleet: The servers.
    """

    __test__ = False  # pytest collects classes whose names begin with Test.

    def __init__(
        self, folder: Path, *, multicast: bool = True, disk: bool = False, clocks: bool = False
    ) -> None:
        """Starts the servers.

        Args:
            folder: The folder for logs and the fleet server's state.
            multicast: Discovery by multicast; else by --cluster_peers.
            disk: Whether the fleet server's disk can be filled.
            clocks: Whether the servers' wall clocks can be set.

        Raises:
            NotPermittedError: Network namespaces are not permitted.
        """
        self._folder = folder
        self.network = Network((*NODES, SPARE, FLEET, LEARNER))
        try:
            peers = () if multicast else (*NODES, SPARE, FLEET)
            self.fleet = Fleet(self.network, server_binary(), folder, peers=peers)
            if disk:
                self.fleet.use_disk()
            if clocks:
                for host in (*NODES, SPARE, FLEET):
                    self.fleet.use_clock(host, wall_clock_library())
            for host in (*NODES, FLEET):
                self.fleet.start(host)
            self.fleet.await_log("event=listening")
        except BaseException:
            self._close()
            raise

    def __enter__(self) -> Testbed:
        """Returns the testbed."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Removes the testbed."""
        self._close()

    def _close(self) -> None:
        self.network.close()
        if hasattr(self, "fleet"):
            self.fleet.close()

    def learner(
        self, script: Script, *, announce: tuple[int, ...] = (), gates: tuple[int, ...] = ()
    ) -> LearnerProcess:
        """Starts a learner, which waits until the fleet server lists all nodes."""
        return LearnerProcess(
            self.network,
            LEARNER,
            self.fleet.address,
            script,
            self._folder,
            node_count=len(NODES),
            announce=announce,
            gates=gates,
        )

    def play(
        self,
        script: Script,
        faults: Mapping[int, Callable[[], None]],
        gates: Mapping[int, Callable[[], None]] | None = None,
    ) -> Trace:
        """Runs a learner and injects faults at its requests.

        Args:
            script: The learner's requests.
            faults: By request number: called while the learner continues.
            gates: By request number: called while the learner waits.

        Raises:
            LearnerError, TimeoutError: The learner was affected by more than a pause.
        """
        gates = gates or {}
        learner = self.learner(script, announce=tuple(faults), gates=tuple(gates))
        while (request := learner.next_announced(TIMEOUT_S)) is not None:
            if request in faults:
                faults[request]()
            if request in gates:
                gates[request]()
                learner.open_gate()
        return learner.trace(TIMEOUT_S)


def single_server_trace(script: Script, folder: Path) -> Trace:
    """Returns the trace of a learner on one server without faults.

    Raises:
        NotPermittedError: Network namespaces are not permitted.
    """
    with Network(("single", LEARNER)) as network:
        address = f"{network.address('single')}:50051"
        with open(folder / "single.log", "wb") as log:
            network.start(
                "single",
                [os.fspath(server_binary()), f"--address={address}", "--allow_insecure"],
                stdout=subprocess.DEVNULL,
                stderr=log,
            )
        return LearnerProcess(network, LEARNER, address, script, folder).trace(TIMEOUT_S)


def assert_same(expected: Trace, actual: Trace, fleet: Fleet) -> None:
    """Fails with the fleet server's log if the traces differ."""
    found = difference(expected, actual)
    assert found is None, f"{found}\nThe fleet server's log:\n{fleet.log()}"
