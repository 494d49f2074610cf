"""Tests of the testbed: packets that a cut drops, and removal of the hosts."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from learner_trace import FIELDS, Trace, difference
from network import Direction, Network, NotPermittedError

_NAMESPACES = Path("/run/netns")
# _ANSWER echoes each word; _ASK sends one.
_ANSWER = """
import socket
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as mine:
    mine.bind(("0.0.0.0", 7))
    print("ready", flush=True)
    while True:
        word, sender = mine.recvfrom(100)
        print(word.decode(), flush=True)
        mine.sendto(word, sender)
"""
_ASK = """
import socket, sys
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as mine:
    mine.settimeout(0.3)
    mine.sendto(sys.argv[2].encode(), (sys.argv[1], 7))
    try:
        print(mine.recvfrom(100)[0].decode())
    except TimeoutError:
        print("silence")
"""


@pytest.fixture
def network() -> Iterator[Network]:
    """Two hosts."""
    try:
        made = Network(("left", "right"))
    except NotPermittedError as error:
        pytest.skip(str(error))
    with made:
        yield made


class EchoServer:
    """An echo server on "right"."""

    def __init__(self, network: Network) -> None:
        self._network = network
        self._process = network.start(
            "right", [sys.executable, "-c", _ANSWER], stdout=subprocess.PIPE, text=True
        )
        assert self._process.stdout is not None
        assert self._process.stdout.readline() == "ready\n"

    def ask(self, word: str) -> str:
        """Sends a word from "left"; returns the response or "silence"."""
        command = [sys.executable, "-c", _ASK, self._network.address("right"), word]
        asking = self._network.start("left", command, stdout=subprocess.PIPE, text=True)
        return asking.communicate()[0].strip()

    def received(self) -> list[str]:
        """Stops the server; returns the words that it received."""
        self._process.kill()
        return self._process.communicate()[0].split()


@pytest.mark.parametrize(
    "direction,received",
    [
        ("to", ["before", "healed"]),
        ("from", ["before", "cut", "healed"]),
        ("both", ["before", "healed"]),
    ],
)
def test_a_cut_drops_the_packets_of_its_direction(
    network: Network, direction: Direction, received: list[str]
) -> None:
    server = EchoServer(network)
    assert server.ask("before") == "before"  # Resolves the address.
    network.cut("right", direction)
    assert server.ask("cut") == "silence"
    network.heal("right")
    assert server.ask("healed") == "healed"
    assert server.received() == received


def test_a_replugged_host_is_reachable(network: Network) -> None:
    server = EchoServer(network)
    network.unplug("right")
    assert server.ask("unplugged") == "silence"
    network.plug("right")
    while server.ask("plugged") != "plugged":
        pass  # The kernel detects the link within a second.


_RUN = """
import signal, subprocess, time
from network import Network
signal.signal(signal.SIGINT, signal.default_int_handler)
with Network(("left",)) as network:
    command = ["sh", "-c", "echo runs; exec sleep 1000"]
    process = network.start("left", command, stdout=subprocess.PIPE)
    process.stdout.readline()
    print(process.pid, flush=True)
    while True:
        time.sleep(0.01)
"""


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGKILL])
def test_an_ended_run_leaves_nothing(network: Network, stop: signal.Signals) -> None:
    run = subprocess.Popen(
        [sys.executable, "-c", _RUN],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        cwd=Path(__file__).parent,
    )
    assert run.stdout is not None
    sleeper = int(run.stdout.readline())
    run.send_signal(stop)
    run.communicate()
    if stop == signal.SIGKILL:
        assert _names_of(run.pid)
        with Network(()):
            pass
    assert not _names_of(run.pid)
    assert _has_ended(sleeper)


def test_a_trace_with_one_different_response_is_detected() -> None:
    digests = np.arange(5 * len(FIELDS), dtype=np.uint32).reshape(5, -1)
    expected = Trace(digests, np.zeros(5))
    assert difference(expected, Trace(digests.copy(), np.ones(5))) is None
    wrong = digests.copy()
    wrong[3, FIELDS.index("rewards")] += 1
    found = difference(expected, Trace(wrong, np.zeros(5)))
    assert found == "the response to request 3 differs in rewards; so do 0 more"
    assert difference(expected, Trace(digests[:4], np.zeros(4))) == "4 responses instead of 5"


def _names_of(process_id: int) -> list[str]:
    return [path.name for path in _NAMESPACES.glob(f"procgen-{process_id}-*")]


def _has_ended(process_id: int) -> bool:
    try:
        os.kill(process_id, 0)
    except ProcessLookupError:
        return True
    # The parent may not have reaped it yet.
    return Path(f"/proc/{process_id}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
