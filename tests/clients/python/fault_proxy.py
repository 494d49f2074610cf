"""A faulty network between client and server."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from procgen_client import Client, errors

_PROXY_VARIABLE = "PROCGEN_FAULT_PROXY"


class Proxy:
    """The program fault-proxy (tests/service/robustness/fault_proxy.h)."""

    def __init__(self, target: str, seed: int, bytes_between_faults: int) -> None:
        program = os.environ.get(_PROXY_VARIABLE)
        if program is None:
            pytest.skip(f"set {_PROXY_VARIABLE}")
        self._process = subprocess.Popen(
            [program, target, str(seed), str(bytes_between_faults)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        assert line.startswith("listening on "), "fault-proxy has ended"
        self.address = line.removeprefix("listening on ").strip()

    def stop(self) -> int:
        """Stops it; returns the number of broken connections."""
        output, _ = self._process.communicate()
        return int(output.removesuffix(" broken\n"))


@contextmanager
def connected(address: str) -> Iterator[Client]:
    """Connects a client; retries if the network breaks the connection."""
    while True:
        try:
            client = Client(address)
            break
        except errors.ProcgenError:
            pass
    with client:
        yield client
