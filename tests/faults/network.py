"""Hosts of a test: network namespaces, each with its own address, on one switch."""

from __future__ import annotations

import itertools
import os
import re
import signal
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

# Names of namespaces: procgen-RUN-NETWORK-HOST. RUN is the id and the start time of the creating
# process, so that a later process with the same id is distinguished.
_PREFIX = "procgen-"
_NAME = re.compile(_PREFIX + r"(\d+-\d+)-\d+-\w+")
_network_numbers = itertools.count()
_FOLDER = Path("/run/netns")
_SWITCH = "switch"
# Names within our own namespaces need not be unique.
_SUBNET = "10.213.0"
# Error messages for missing permissions or missing kernel features.
_PROHIBITED = re.compile("not permitted|denied|not supported|unknown device type", re.IGNORECASE)

# The packets that a cut drops: those to the host, those from it, or both.
Direction = Literal["to", "from", "both"]


class NotPermittedError(Exception):
    """Network namespaces are not permitted here; the message contains the reason."""


class Network:
    """Hosts on one Ethernet switch, with multicast, without a connection to other networks.

    The switch is a bridge in its own namespace; each host has one cable to it. Leaving the context
    removes everything. After a killed run, its processes end and the next run removes the rest.
    """

    def __init__(self, hosts: Sequence[str]) -> None:
        """Creates the hosts; names have up to 10 letters and digits."""
        remove_stale()
        self._hosts = tuple(hosts)
        self._number = next(_network_numbers)
        self._processes: list[subprocess.Popen[Any]] = []
        try:
            self._make()
        except BaseException as error:
            self.close()
            if reason := _prohibition(error):
                raise NotPermittedError(f"no network namespaces here: {reason}") from error
            raise

    def __enter__(self) -> Network:
        """Returns the network."""
        return self

    def __exit__(self, *exception: object) -> None:
        """Removes the network."""
        self.close()

    def address(self, host: str) -> str:
        """The IPv4 address of a host."""
        return f"{_SUBNET}.{self._hosts.index(host) + 1}"

    def start(self, host: str, command: Sequence[str], **popen: Any) -> subprocess.Popen[Any]:
        """Starts a program on a host. It is killed by close() or when this process ends."""
        process = subprocess.Popen(
            ["ip", "netns", "exec", self._namespace(host), "setpriv", "--pdeathsig=KILL", *command],
            **{"stdin": subprocess.DEVNULL, "start_new_session": True, **popen},
        )
        self._processes.append(process)
        return process

    def cut(self, host: str, direction: Direction) -> None:
        """Silently drops all packets in a direction; the host's link stays up."""
        if direction in ("to", "both"):
            _drop_arriving(self._namespace(host), "eth0")
        if direction in ("from", "both"):
            _drop_arriving(self._namespace(_SWITCH), _port(host))

    def heal(self, host: str) -> None:
        """Undoes cut."""
        # Deleting a missing table is an error, so the table is added first.
        _nft(self._namespace(host), "add table netdev cut; delete table netdev cut")
        table = f"netdev cut_{host}"
        _nft(self._namespace(_SWITCH), f"add table {table}; delete table {table}")

    def unplug(self, host: str) -> None:
        """Takes the switch's end of the cable down; the host's link goes down."""
        self._ip(_SWITCH, f"link set dev {_port(host)} down")

    def plug(self, host: str) -> None:
        """Undoes unplug."""
        self._ip(_SWITCH, f"link set dev {_port(host)} up")

    def close(self) -> None:
        """Kills the started programs and removes the hosts."""
        for process in self._processes:
            if process.poll() is None:
                process.kill()
        for process in self._processes:
            process.wait()
        for host in (*self._hosts, _SWITCH):
            _remove(self._namespace(host))

    def _make(self) -> None:
        for host in (_SWITCH, *self._hosts):
            _run(["ip", "netns", "add", self._namespace(host)])
        # Without snooping, multicast packets go to all hosts.
        bridge = "link add bridge0 type bridge mcast_snooping 0"
        self._ip(_SWITCH, bridge, "link set dev bridge0 up")
        for host in self._hosts:
            port = _port(host)
            self._ip(
                _SWITCH,
                f"link add {port} type veth peer name eth0 netns {self._namespace(host)}",
                f"link set dev {port} master bridge0 up",
            )
            self._ip(
                host,
                "link set dev lo up",
                f"address add {self.address(host)}/24 dev eth0",
                "link set dev eth0 up",
            )
        # Checks that packets can be dropped.
        if self._hosts:
            self.cut(self._hosts[0], "both")
            self.heal(self._hosts[0])

    def _namespace(self, host: str) -> str:
        return f"{_PREFIX}{_run_name(os.getpid())}-{self._number}-{host}"

    def _ip(self, host: str, *lines: str) -> None:
        _run(["ip", "-n", self._namespace(host), "-batch", "-"], "\n".join(lines) + "\n")


def remove_stale() -> None:
    """Removes the namespaces of ended runs, and the processes in them."""
    if not _FOLDER.is_dir():
        return
    for name in sorted(entry.name for entry in _FOLDER.iterdir()):
        match = _NAME.fullmatch(name)
        if match and not _is_alive(match.group(1)):
            _remove(name)


def _prohibition(error: BaseException) -> str | None:
    """The reason if a command failed for lack of permission; None for other errors."""
    if isinstance(error, FileNotFoundError):
        return f"there is no program {error.filename}"
    if isinstance(error, subprocess.CalledProcessError) and _PROHIBITED.search(error.stderr):
        return str(error.stderr).strip().splitlines()[0]
    return None


def _run_name(process_id: int) -> str | None:
    try:
        # The fields after the program's name, which may contain blanks and brackets.
        fields = Path(f"/proc/{process_id}/stat").read_text().rpartition(")")[2].split()
    except (FileNotFoundError, ProcessLookupError):
        return None
    return f"{process_id}-{fields[19]}"


def _is_alive(run: str) -> bool:
    return _run_name(int(run.partition("-")[0])) == run


def _port(host: str) -> str:
    return f"port-{host}"


def _drop_arriving(namespace: str, interface: str) -> None:
    table = "cut" if interface == "eth0" else f"cut_{interface.removeprefix('port-')}"
    hook = f"type filter hook ingress device {interface} priority 0; policy drop;"
    _nft(namespace, f"add table netdev {table}; add chain netdev {table} drop_all {{ {hook} }}")


def _nft(namespace: str, rules: str) -> None:
    _run(["ip", "netns", "exec", namespace, "nft", rules])


def _run(command: list[str], text: str = "") -> str:
    return subprocess.run(
        command, input=text, capture_output=True, text=True, check=True
    ).stdout


def _remove(namespace: str) -> None:
    """Kills the processes of a namespace and removes it; another run may do so concurrently."""
    if not (_FOLDER / namespace).exists():
        return
    pids = subprocess.run(
        ["ip", "netns", "pids", namespace], capture_output=True, text=True, check=False
    )
    for process_id in pids.stdout.split():
        try:
            os.kill(int(process_id), signal.SIGKILL)
        except ProcessLookupError:
            pass
    subprocess.run(["ip", "netns", "delete", namespace], capture_output=True, check=False)
