"""Connections that are cut at random instants, over TCP, TLS and a unix socket.

All that a pool can do is under way: halves that are sent ahead, samplers, next levels, resets,
frame stacks, in all autoreset modes. The trace equals that of a pool in this process, byte for
byte.
"""

from __future__ import annotations

import hashlib
import os
import random
import select
import socket
import struct
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest
from conftest import server_binary

from procgen_client import Batch, Client, Credentials, LevelSampler, Pool, Reset, ServerProcess

# Number of cuts per transport and mode; the long form has 334, so 1,000 per transport.
_CUTS = int(os.environ.get("PROCGEN_CUTS", "10"))
_GAMES = ["maze", "bigfish"]
_ENV_COUNT = 12
_HALF = _ENV_COUNT // 2
_OPTIONS = {"distribution_mode": "easy", "rand_seed": 5, "frame_stack": 3}
_RESET_CONNECTION = struct.pack("ii", 1, 0)  # SO_LINGER: a close resets the connection.


class Cutter:
    """Forwards connections to a server and cuts all of them at random instants."""

    def __init__(self, family: int, address: object, target: object, seed: int) -> None:
        self.cut_count = 0
        self._family, self._target = family, target
        self._random = random.Random(seed)
        self._listener = socket.socket(family, socket.SOCK_STREAM)
        self._listener.bind(address)
        self._listener.listen()
        self.address = self._listener.getsockname()
        self._wake, self._waker = socket.socketpair()
        self._pairs: dict[socket.socket, socket.socket] = {}
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def close(self) -> None:
        self._waker.close()
        self._thread.join()
        self._cut()
        self._listener.close()
        self._wake.close()

    def _run(self) -> None:
        while True:
            ready = select.select(
                [self._wake, self._listener, *self._pairs], [], [], self._random.uniform(0, 0.03)
            )[0]
            if self._wake in ready:
                return
            if self._listener in ready:
                self._accept()
            for one in ready:
                if one in self._pairs:
                    self._forward(one)
            # Several times while a connection is made and its pool restored, or while it runs.
            if self._pairs and self._random.random() < 0.02:
                self._cut()
                self.cut_count += 1

    def _accept(self) -> None:
        learner = self._listener.accept()[0]
        server = socket.socket(self._family, socket.SOCK_STREAM)
        server.connect(self._target)
        self._pairs |= {learner: server, server: learner}

    def _forward(self, one: socket.socket) -> None:
        with suppress(OSError):
            if data := one.recv(self._random.choice([100, 1 << 16])):
                self._pairs[one].sendall(data)
                return
        for each in (one, self._pairs.pop(one)):
            self._pairs.pop(each, None)
            each.close()

    def _cut(self) -> None:
        for each in self._pairs:
            if self._family == socket.AF_INET:
                each.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _RESET_CONNECTION)
            each.close()
        self._pairs.clear()


class Script:
    """The requests of a learner, drawn from a seed and from the batches so far."""

    def __init__(self, pool: Pool) -> None:
        self._pool = pool
        self._random = np.random.default_rng(7)
        self._resets: list[list[int]] = [[], []]  # Of the environments that must be reset, by half.
        self._trace = hashlib.sha256()
        self._send(0)
        self._send(1)

    def round(self, number: int) -> str:
        """Steps both halves once, and does more now and then. Returns the hash of all batches."""
        for half in (0, 1):
            self._add(self._pool.receive(), half)
            if half == 0 or number % 5 != 0:
                self._send(half)
        if number % 5 == 0:
            self._add(self._pool.receive(), 0)
            self._change(number)
            self._send(0)
            self._send(1)
        return self._trace.hexdigest()

    def _send(self, half: int) -> None:
        first = half * _HALF
        environment = first + int(self._random.integers(_HALF))
        resets: list[int | Reset] = [*self._resets[half]]
        if self._random.random() < 0.1 and environment not in resets:
            resets.append(Reset(environment, level_seed=int(self._random.integers(99))))
        self._pool.send_step(
            self._random.integers(-1, 15, _HALF),
            first_env=first,
            env_count=_HALF,
            observe=bool(self._random.random() < 0.8),
            repeat_count=int(self._random.integers(1, 4)),
            final_observations=True,
            next_levels={environment: int(self._random.integers(99))},
            resets=resets,
        )

    def _change(self, number: int) -> None:
        kind = number // 5 % 3
        if kind == 0:
            seeds = [int(each) for each in self._random.integers(1000, size=20)]
            self._pool.set_level_sampler(LevelSampler(seeds, rand_seed=number))
        elif kind == 1:
            states = self._pool.save_states([0, 7])
            self._pool.restore_states({0: states[0], 7: states[1]})
        else:
            self._pool.clone_states([(2, 0), (9, 7)])
        batch = self._pool.observe()
        for half in (0, 1):
            self._note(batch.ended[half * _HALF : (half + 1) * _HALF], half)

    def _add(self, batch: Batch, half: int) -> None:
        for name in ("observations", "rewards", "first", "terminated", "truncated", "level_seeds"):
            array = getattr(batch, name)
            self._trace.update(b"" if array is None else np.ascontiguousarray(array).tobytes())
        if batch.final_observations is not None:
            self._trace.update(batch.final_observations[batch.ended].tobytes())
        self._note(batch.ended, half)

    def _note(self, ended: np.ndarray, half: int) -> None:
        if self._pool.autoreset_mode == "disabled":
            self._resets[half] = [half * _HALF + int(row) for row in np.flatnonzero(ended)]


def _certificates(folder: Path) -> list[str]:
    certificate, key = folder / "server.pem", folder / "server.key"
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1"]
        + ["-nodes", "-days", "2", "-subj", "/CN=test", "-addext", "subjectAltName=IP:127.0.0.1"]
        + ["-keyout", str(key), "-out", str(certificate)],
        check=True,
        capture_output=True,
    )
    return [f"--tls_certificate={certificate}", f"--tls_key={key}"]


@contextmanager
def _line(transport: str, folder: Path) -> Iterator[tuple[Cutter, Client]]:
    """A server, a cutter before it, and a client that is connected through the cutter."""
    flags = _certificates(folder) if transport == "tls" else []
    path = str(folder / "server")
    at = f"unix:{path}" if transport == "unix" else "127.0.0.1:0"
    with ServerProcess(server_binary(), flags, workers=1, address=at) as server:
        if transport == "unix":
            cutter = Cutter(socket.AF_UNIX, str(folder / "cutter"), path, 1)
            address = f"unix:{cutter.address}"
        else:
            host, port = server.address.rsplit(":", 1)
            cutter = Cutter(socket.AF_INET, ("127.0.0.1", 0), (host, int(port)), 1)
            address = f"127.0.0.1:{cutter.address[1]}"
        ca = {"credentials": Credentials(ca=folder / "server.pem")} if flags else {}
        try:
            client = None
            while client is None:
                with suppress(Exception):
                    client = Client(address, **ca)
            with client:
                yield cutter, client
        finally:
            cutter.close()


def _started(client: Client, mode: str) -> Pool:
    while True:
        with suppress(Exception):  # Creating a pool is not repeated by the client.
            return Pool(_GAMES, _ENV_COUNT, server=client, autoreset_mode=mode, **_OPTIONS)


@pytest.mark.parametrize("mode", ["same_step", "next_step", "disabled"])
@pytest.mark.parametrize("transport", ["tcp", "tls", "unix"])
def test_cuts_change_nothing(tmp_path: Path, transport: str, mode: str) -> None:
    hashes = []
    with _line(transport, tmp_path) as (cutter, client), _started(client, mode) as pool:
        script = Script(pool)
        end = cutter.cut_count + _CUTS
        while cutter.cut_count < end:
            hashes.append(script.round(len(hashes)))
    with Pool(_GAMES, _ENV_COUNT, autoreset_mode=mode, **_OPTIONS) as pool:
        script = Script(pool)
        expected = [script.round(number) for number in range(len(hashes))]
    # The first that differs says where.
    differing = [i for i, (a, b) in enumerate(zip(hashes, expected, strict=True)) if a != b]
    assert not differing, f"round {differing[0]} of {len(hashes)}"
