"""Schedules of faults, drawn from a seed, and what injects them."""

from __future__ import annotations

import heapq
import itertools
import random
import time
from collections.abc import Iterable
from dataclasses import dataclass

from learner_process import LearnerProcess
from learner_script import Script
from learner_trace import Trace
from network import Direction
from testbed import LEARNER, TIMEOUT_S, Testbed

_CUTS: dict[str, Direction] = {"cut to": "to", "cut from": "from", "cut both": "both"}
# Faults after which a host is silent. They can hit the learner, too.
SILENT_KINDS = ("pause", *_CUTS, "unplug")
KINDS = ("kill", "drain", *SILENT_KINDS)
# Themes: each adds a kind of fault of servers.
THEMES = ("threads", "clock")
_CLOCK_SECONDS = (-86400, -3600, -30, 30, 3600, 86400)
# Durations of faults, shorter and longer than failure detection takes.
_SECONDS = (0.05, 0.3, 1.0, 2.0, 3.5, 6.0)


@dataclass(frozen=True)
class Fault:
    """A fault of a host before a request, which ends after some time."""

    request: int
    host: str
    kind: str  # One of KINDS or THEMES.
    seconds: float  # A killed or drained server starts again then; infinity: never.
    clock_seconds: int = 0  # For the kind "clock".

    def __str__(self) -> str:
        """Returns e.g. ``request 312: cut to a for 3.5 s``."""
        clock = f" {self.clock_seconds:+d} s" if self.kind == "clock" else ""
        return f"request {self.request}: {self.kind}{clock} {self.host} for {self.seconds:g} s"


def draw(
    seed: int, request_count: int, hosts: Iterable[str], theme: str | None = None
) -> list[Fault]:
    """Returns the schedule of a seed: four to seven faults, some of them concurrent.

    With a theme, about half of the faults are of its kind.
    """
    rng = random.Random(seed)
    servers = tuple(hosts)
    faults = []
    requests = sorted(rng.sample(range(request_count // 20, request_count), rng.randint(4, 7)))
    for request in requests:
        seconds = rng.choice(_SECONDS)
        if theme is not None and (request == requests[0] or rng.random() < 0.5):
            clock = rng.choice(_CLOCK_SECONDS) if theme == "clock" else 0
            faults.append(Fault(request, rng.choice(servers), theme, seconds, clock))
        elif rng.random() < 0.15:
            faults.append(Fault(request, LEARNER, rng.choice(SILENT_KINDS), seconds))
        else:
            faults.append(Fault(request, rng.choice(servers), rng.choice(KINDS), seconds))
    return faults


def play(testbed: Testbed, script: Script, schedule: list[Fault]) -> Trace:
    """Runs a learner and injects faults meanwhile. Afterwards no server has a pool."""
    learner = testbed.learner(script, announce=tuple(fault.request for fault in schedule))
    driver = FaultDriver(testbed, learner)
    driver.run(schedule)
    trace = learner.trace(TIMEOUT_S)
    driver.undo_all()
    testbed.servers.await_freed()
    return trace


class FaultDriver:
    """Injects the faults of a schedule."""

    def __init__(self, testbed: Testbed, learner: LearnerProcess) -> None:
        """Starts without a fault."""
        self._testbed = testbed
        self._learner = learner
        self._order = itertools.count()
        self._undone: list[tuple[float, int, Fault]] = []  # A heap, by end time.
        self._faulty: dict[str, Fault] = {}

    def run(self, schedule: list[Fault]) -> None:
        """Injects faults until the learner ends."""
        by_request: dict[int, list[Fault]] = {}
        for fault in schedule:
            by_request.setdefault(fault.request, []).append(fault)
        announced_time = time.monotonic()
        while True:
            wait = self._undone[0][0] - time.monotonic() if self._undone else TIMEOUT_S
            try:
                request = self._learner.next_announced(max(0.0, min(wait, TIMEOUT_S)))
            except TimeoutError:
                if time.monotonic() - announced_time > TIMEOUT_S:
                    raise
                self._undo_due()
                continue
            if request is None:
                return
            announced_time = time.monotonic()
            for fault in by_request[request]:
                self.begin(fault)

    def begin(self, fault: Fault) -> None:
        """Injects a fault; first ends an active fault of that host."""
        # One fault at a time per host.
        if fault.host in self._faulty:
            self.undo(fault.host)
        servers, network = self._testbed.servers, self._testbed.network
        if fault.kind == "kill":
            servers.kill(fault.host)
        elif fault.kind == "drain":
            servers.drain(fault.host)
        elif fault.kind == "pause":
            if fault.host == LEARNER:
                self._learner.pause()
            else:
                servers.pause(fault.host)
        elif fault.kind == "unplug":
            network.unplug(fault.host)
        elif fault.kind == "threads":
            servers.limit_threads(fault.host)
        elif fault.kind == "clock":
            servers.set_clock(fault.host, fault.clock_seconds)
        else:
            network.cut(fault.host, _CUTS[fault.kind])
        self._faulty[fault.host] = fault
        until = time.monotonic() + fault.seconds
        heapq.heappush(self._undone, (until, next(self._order), fault))

    def _undo_due(self) -> None:
        while self._undone and self._undone[0][0] <= time.monotonic():
            _, _, fault = heapq.heappop(self._undone)
            if self._faulty.get(fault.host) is fault:
                self.undo(fault.host)

    def undo_all(self) -> None:
        """Ends all active faults, except that what was to stay dead does."""
        for host, fault in list(self._faulty.items()):
            if fault.seconds < float("inf"):
                self.undo(host)

    def undo(self, host: str) -> None:
        """Ends the active fault of a host before its time."""
        servers, network = self._testbed.servers, self._testbed.network
        fault = self._faulty.pop(host)
        if fault.kind == "kill":
            servers.start(host)
        elif fault.kind == "drain":
            status = servers.await_exit(host, TIMEOUT_S)
            assert status == 0, f"{host} has drained and ended with status {status}"
            servers.start(host)
        elif fault.kind == "pause":
            if host == LEARNER:
                self._learner.resume()
            else:
                servers.resume(host)
        elif fault.kind == "unplug":
            network.plug(host)
        elif fault.kind == "threads":
            servers.unlimit_threads(host)
        elif fault.kind == "clock":
            servers.set_clock(host, 0)
        else:
            network.heal(host)
