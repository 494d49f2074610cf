"""Schedules of faults, drawn from a seed."""

from __future__ import annotations

import heapq
import itertools
import random
import time
from dataclasses import dataclass

from fleet import FLEET
from learner_process import LearnerProcess
from network import Direction
from testbed import NODES, SPARE, TIMEOUT_S, Testbed

_CUTS: dict[str, Direction] = {"cut to": "to", "cut from": "from", "cut both": "both"}
# Only nodes drain: a draining fleet server would end its learners' streams.
KINDS = ("kill", "pause", *_CUTS, "unplug", "drain")
# Themes: each adds a kind of fault, which can hit these hosts.
THEMES: dict[str, tuple[str, ...]] = {
    "disk": (FLEET,),
    "threads": (*NODES, FLEET),
    "clock": (*NODES, FLEET),
}
_CLOCK_SECONDS = (-86400, -3600, -30, 30, 3600, 86400)
# Durations of faults, shorter and longer than failure detection takes.
_SECONDS = (0.05, 0.3, 1.0, 2.0, 3.5, 6.0)


@dataclass(frozen=True)
class Fault:
    """A fault of a host before a request, which ends after some time."""

    request: int
    host: str
    kind: str  # One of KINDS or THEMES, or "add": a node joins.
    seconds: float = 0.0
    clock_seconds: int = 0  # For the kind "clock".

    def __str__(self) -> str:
        """Returns e.g. ``request 312: cut to a for 3.5 s``."""
        duration = "" if self.kind == "add" else f" for {self.seconds:g} s"
        clock = f" {self.clock_seconds:+d} s" if self.kind == "clock" else ""
        return f"request {self.request}: {self.kind}{clock} {self.host}{duration}"


def draw(seed: int, request_count: int, theme: str | None = None) -> list[Fault]:
    """Returns the schedule of a seed: four to seven faults, some of them concurrent.

    With a theme, about half of the faults are of its kind; "disk" ends with a kill.
    """
    rng = random.Random(seed)
    faults = []
    requests = sorted(rng.sample(range(request_count // 20, request_count), rng.randint(4, 7)))
    for request in requests:
        if theme == "disk" and request == requests[-1]:
            # The pools must be durable again by now.
            faults.append(Fault(request, FLEET, "kill", rng.choice(_SECONDS)))
            continue
        if theme is not None and (request == requests[0] or rng.random() < 0.5):
            host = rng.choice(THEMES[theme])
            clock = rng.choice(_CLOCK_SECONDS) if theme == "clock" else 0
            faults.append(Fault(request, host, theme, rng.choice(_SECONDS), clock))
            continue
        host = rng.choice((*NODES, *NODES, FLEET, SPARE))
        if host == SPARE:
            faults.append(Fault(request, SPARE, "add"))
            continue
        kinds = KINDS[:-1] if host == FLEET else KINDS
        faults.append(Fault(request, host, rng.choice(kinds), rng.choice(_SECONDS)))
    return faults


class FaultDriver:
    """Injects the faults of a schedule."""

    def __init__(self, testbed: Testbed) -> None:
        """Starts without a fault."""
        self._testbed = testbed
        self._order = itertools.count()
        self._undone: list[tuple[float, int, Fault]] = []  # A heap, by end time.
        self._faulty: dict[str, Fault] = {}

    def run(self, schedule: list[Fault], learner: LearnerProcess) -> None:
        """Injects faults until the learner ends.

        Raises:
            TimeoutError: The learner waits too long.
        """
        by_request: dict[int, list[Fault]] = {}
        for fault in schedule:
            by_request.setdefault(fault.request, []).append(fault)
        announced_time = time.monotonic()
        while True:
            wait = self._undone[0][0] - time.monotonic() if self._undone else TIMEOUT_S
            try:
                request = learner.next_announced(max(0.0, min(wait, TIMEOUT_S)))
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
        fleet, network = self._testbed.fleet, self._testbed.network
        if fault.kind == "add":
            if not fleet.is_started(fault.host):
                fleet.start(fault.host)
            return
        if fault.kind == "kill":
            fleet.kill(fault.host)
        elif fault.kind == "drain":
            fleet.drain(fault.host)
        elif fault.kind == "pause":
            fleet.pause(fault.host)
        elif fault.kind == "unplug":
            network.unplug(fault.host)
        elif fault.kind == "disk":
            fleet.fill_disk()
        elif fault.kind == "threads":
            fleet.limit_threads(fault.host)
        elif fault.kind == "clock":
            fleet.set_clock(fault.host, fault.clock_seconds)
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

    def undo(self, host: str) -> None:
        """Ends the active fault of a host before its time."""
        fleet, network = self._testbed.fleet, self._testbed.network
        fault = self._faulty.pop(host)
        if fault.kind == "kill":
            fleet.start(host)
        elif fault.kind == "drain":
            fleet.await_exit(host, TIMEOUT_S)
            fleet.start(host)
        elif fault.kind == "pause":
            fleet.resume(host)
        elif fault.kind == "unplug":
            network.plug(host)
        elif fault.kind == "disk":
            fleet.free_disk(TIMEOUT_S)
        elif fault.kind == "threads":
            fleet.unlimit_threads(host)
        elif fault.kind == "clock":
            fleet.set_clock(host, 0)
        else:
            network.heal(host)
