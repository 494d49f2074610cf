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
# Drains are for nodes alone: a fleet server that drains ends its learners' streams.
KINDS = ("kill", "pause", *_CUTS, "unplug", "drain")
# Each with a kind of fault of its own, besides the others: the hosts that it may befall.
THEMES: dict[str, tuple[str, ...]] = {
    "disk": (FLEET,),
    "threads": (*NODES, FLEET),
    "clock": (*NODES, FLEET),
}
_CLOCK_SECONDS = (-86400, -3600, -30, 30, 3600, 86400)
# Shorter and longer than failure detection takes.
_SECONDS = (0.05, 0.3, 1.0, 2.0, 3.5, 6.0)


@dataclass(frozen=True)
class Fault:
    """Something happens to a host before a request, and is undone some time later."""

    request: int
    host: str
    kind: str  # One of KINDS or of THEMES, or "add": a node comes to stay.
    seconds: float = 0.0
    clock_seconds: int = 0  # Of the kind "clock".

    def __str__(self) -> str:
        """Gives e.g. ``request 312: cut to a for 3.5 s``."""
        duration = "" if self.kind == "add" else f" for {self.seconds:g} s"
        clock = f" {self.clock_seconds:+d} s" if self.kind == "clock" else ""
        return f"request {self.request}: {self.kind}{clock} {self.host}{duration}"


def draw(seed: int, request_count: int, theme: str | None = None) -> list[Fault]:
    """The schedule of a seed: four to seven faults, at times several at once.

    With one of THEMES, about every other fault is of that kind, and "disk" ends with a kill.
    """
    rng = random.Random(seed)
    faults = []
    requests = sorted(rng.sample(range(request_count // 20, request_count), rng.randint(4, 7)))
    for request in requests:
        if theme == "disk" and request == requests[-1]:
            # What the disk did not take must be there by now.
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
        """Begins with everything in order."""
        self._testbed = testbed
        self._order = itertools.count()
        self._undone: list[tuple[float, int, Fault]] = []  # A heap, by when.
        self._faulty: dict[str, Fault] = {}

    def run(self, schedule: list[Fault], learner: LearnerProcess) -> None:
        """Until the learner has ended.

        Raises:
            TimeoutError: The learner waits for too long.
        """
        by_request: dict[int, list[Fault]] = {}
        for fault in schedule:
            by_request.setdefault(fault.request, []).append(fault)
        heard_time = time.monotonic()
        while True:
            wait = self._undone[0][0] - time.monotonic() if self._undone else TIMEOUT_S
            try:
                request = learner.next_announced(max(0.0, min(wait, TIMEOUT_S)))
            except TimeoutError:
                if time.monotonic() - heard_time > TIMEOUT_S:
                    raise
                self._undo_due()
                continue
            if request is None:
                return
            heard_time = time.monotonic()
            for fault in by_request[request]:
                self.begin(fault)

    def begin(self, fault: Fault) -> None:
        """Brings it about; what was out of order on that host before is put in order."""
        # One at a time on a host.
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
        """Puts in order what is not on that host; without waiting for the time of the fault."""
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
