#!/usr/bin/env python3
"""The idle traffic of a cluster, and how soon its nodes notice changes.

Each node is a process in a network namespace of its own; a bridge connects them. So the counts are
those of the kernel for each node's network interface. Needs root; changes nothing outside a new
network and mount namespace.

    packets, bytes   sent by a node per second (with the Ethernet header), mean over
                     the nodes after a pause; in parentheses the node that sent most
    join             until all nodes list each other, after the last of them started; they start
                     five per second, because 64 that start at once keep two cores busy for minutes
    late             until a node that joins later lists all
    crash, stop      until the last node no longer lists one that was killed, or that left
"""

from __future__ import annotations

import argparse
import json
import os
import select
import subprocess
import sys
import time
from pathlib import Path

_START_INTERVAL = 0.2


def _run(command: str, text: str = "") -> str:
    return subprocess.run(
        command.split(), input=text, check=True, capture_output=True, text=True
    ).stdout


class _Node:
    """One process; `counts` has (monotonic seconds, number of listed nodes) for each change."""

    def __init__(self, program: Path, number: int, peers: list[str]) -> None:
        self.number = number
        self.counts: list[tuple[float, int]] = []
        self._rest = b""
        inside = ["ip", "netns", "exec", f"n{number}"]
        command = [str(program), f"node-{number}", f"{_address(number)}:50051", *peers]
        self.process = subprocess.Popen(
            [*inside, *command], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )

    def read(self) -> None:
        assert self.process.stdout is not None
        lines = (self._rest + os.read(self.process.stdout.fileno(), 1 << 16)).split(b"\n")
        self._rest = lines.pop()
        for line in lines:
            seconds, count = line.split()
            self.counts.append((float(seconds), int(count)))


def _address(number: int) -> str:
    return f"10.77.0.{number + 1}"


def _hardware_address(number: int) -> str:
    return f"02:00:00:00:00:{number + 1:02x}"


def _make_network(count: int) -> None:
    _run("ip link set lo up")
    _run("ip link add bridge0 type bridge mcast_snooping 0")
    _run("ip link set bridge0 up")
    # The kernel's ARP table is for all namespaces together, and too small for 64 nodes.
    neighbours = "".join(
        f"neigh add {_address(i)} lladdr {_hardware_address(i)} dev eth0\n" for i in range(count)
    )
    for number in range(count):
        inside = f"ip netns exec n{number}"
        _run(f"ip netns add n{number}")
        peer = f"peer name eth0 netns n{number} address {_hardware_address(number)}"
        _run(f"ip link add v{number} type veth {peer}")
        # No IPv6 addresses: their announcements would count, too.
        _run(f"ip link set v{number} addrgenmode none")
        _run(f"ip link set v{number} master bridge0 up")
        _run(f"{inside} ip link set eth0 addrgenmode none")
        _run(f"{inside} ip addr add {_address(number)}/24 dev eth0")
        _run(f"{inside} ip link set eth0 up")
        _run(f"{inside} ip -batch -", neighbours)
        _run(f"{inside} ip link set lo up")


def _sent(nodes: list[_Node]) -> list[tuple[int, int]]:
    """Packets and bytes that each node has sent: what its end of the bridge received."""
    links = {link["ifname"]: link["stats64"]["rx"] for link in json.loads(_run("ip -s -j link"))}
    return [(links[f"v{n.number}"]["packets"], links[f"v{n.number}"]["bytes"]) for n in nodes]


def _await(nodes: list[_Node], count: int, begin: float, timeout: float = 90) -> float:
    """Seconds from `begin` until the last of the nodes listed `count`; inf after the timeout."""
    while any(not node.counts or node.counts[-1][1] != count for node in nodes):
        readers = {node.process.stdout: node for node in nodes}
        ready, _, _ = select.select(list(readers), [], [], 1)
        for stdout in ready:
            readers[stdout].read()
        if time.monotonic() > begin + timeout:
            return float("inf")
    return max(node.counts[-1][0] for node in nodes) - begin


def _measure(
    program: Path, count: int, with_peers: bool, pause: float, seconds: float
) -> tuple[str, float]:
    """Returns a row of the table, and the highest number of packets per second of a node."""
    peers = [_address(number) for number in range(count)] if with_peers else []
    nodes = []
    try:
        for number in range(count):
            begin = time.monotonic()
            nodes.append(_Node(program, number, peers))
            time.sleep(_START_INTERVAL)
        join = _await(nodes, count, begin)
        time.sleep(pause)
        before, started = _sent(nodes), time.monotonic()
        time.sleep(seconds)
        after, elapsed = _sent(nodes), time.monotonic() - started
        packets = [(new[0] - old[0]) / elapsed for new, old in zip(after, before)]
        traffic = [(new[1] - old[1]) / elapsed for new, old in zip(after, before)]

        victim = nodes.pop(0)
        began = time.monotonic()
        victim.process.kill()
        crash = _await(nodes, count - 1, began)

        began = time.monotonic()
        joiner = _Node(program, 0, peers)
        nodes.append(joiner)
        late = _await([joiner], count, began)
        _await(nodes, count, began)

        leaver = nodes.pop(0)
        began = time.monotonic()
        assert leaver.process.stdin is not None
        leaver.process.stdin.close()
        stop = _await(nodes, count - 1, began)
        leaver.process.wait()
    finally:
        for node in nodes:
            node.process.kill()
            node.process.wait()
    row = (
        f"| {count} | {'peers' if with_peers else 'multicast'} | "
        f"{sum(packets) / count:.1f} ({max(packets):.1f}) | {sum(traffic) / count:,.0f} "
        f"({max(traffic):,.0f}) | {join:.1f} s | {late:.1f} s | {crash:.1f} s | {stop:.1f} s |"
    )
    return row, max(packets)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("program", type=Path, help="procgen-benchmark-cluster-node")
    parser.add_argument("--nodes", type=int, nargs="+", default=[2, 4, 8, 16, 32, 64])
    parser.add_argument("--discovery", nargs="+", default=["multicast", "peers"])
    parser.add_argument("--pause", type=float, default=10, help="seconds before the traffic counts")
    parser.add_argument("--seconds", type=float, default=90, help="for which the traffic counts")
    parser.add_argument("--packets_max", type=float, help="per second; more are an error")
    arguments = parser.parse_args()
    if os.environ.get("PROCGEN_NETWORK_NAMESPACE") is None:
        if subprocess.run(["unshare", "--net", "--mount", "true"]).returncode != 0:
            sys.exit(77)  # the test is skipped
        os.environ["PROCGEN_NETWORK_NAMESPACE"] = "1"
        inside = 'mount -t tmpfs tmpfs /run && exec "$0" "$@"'
        command = ["unshare", "--net", "--mount", "sh", "-c", inside, sys.executable, *sys.argv]
        os.execvp(command[0], command)
    _make_network(max(arguments.nodes))
    print("| nodes | discovery | packets/s | bytes/s | join | late | crash | stop |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for count in arguments.nodes:
        for discovery in arguments.discovery:
            with_peers = discovery == "peers"
            row, packets = _measure(
                arguments.program, count, with_peers, arguments.pause, arguments.seconds
            )
            print(row, flush=True)
            if arguments.packets_max is not None and packets > arguments.packets_max:
                sys.exit(f"{packets:.1f} packets per second, allowed: {arguments.packets_max}")


if __name__ == "__main__":
    main()
