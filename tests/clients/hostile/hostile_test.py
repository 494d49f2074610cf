"""Clients with servers that return invalid responses.

A learner of each client sends the same requests in each mode; each mode has its own address. It
prints "begin MODE" and then a line of JSON: a digest of all received data, or an error of the
client's type. Responses are those of a real server, changed by hostile_answers.py and
hostile_frames.py.
"""

from __future__ import annotations

import json
import os
import queue
import subprocess
import threading
from collections.abc import Iterator

import hostile_answers
import mutated_answers
import pytest
from hostile_frames import FRAMES, HostileConnection
from hostile_server import HostileServer

from procgen_client import ServerProcess

# Time limit of a session. A rejected client takes about a second, one that reconnects or that waits
# for the end of a stream some more.
_SESSION_SECONDS = 40
# For all sessions of a learner.
_MEMORY_KIB_MAX = 700 * 1024

# Per encoding.
_MUTATION_COUNT = 40

_LEARNER = os.environ["PROCGEN_HOSTILE_LEARNER"].split("|")
# The grpcio fallback has raw observations only.
_ENCODINGS = ["raw", "delta_zstd"]
if os.environ.get("PROCGEN_CLIENT_TRANSPORT") == "grpcio":
    _ENCODINGS.pop()
# Modes that a client may not detect; its received data must be correct then.
_OVERLOOKED = {"shared_batch", "frame_cut"}
# Modes of hostile_server.py after which a learner may continue, like those of hostile_frames.py.
_TOLERATED = ["catalog_empty", "compressed"]
# Node's HTTP/2 does not report these errors of a connection, not even to @grpc/grpc-js, so the
# client waits indefinitely (clients/node/README.md).
_OF_CONNECTIONS = {
    "frame_of_16_mib",
    "headers_that_are_none",
    "noise",
    "settings_that_are_none",
    "settings_with_large_window",
}
_UNSEEN = _OF_CONNECTIONS if "learner.js" in _LEARNER else set()


class _Run:
    """A learner's sessions against some addresses."""

    def __init__(self, addresses: dict[str, str], encoding: str = "raw") -> None:
        arguments = [f"{mode}={encoding}={address}" for mode, address in addresses.items()]
        self._process = subprocess.Popen(
            [*_LEARNER, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        self._lines: queue.Queue[str] = queue.Queue()
        self._errors = ""
        targets = (self._read, self._read_errors)
        self._readers = [threading.Thread(target=target) for target in targets]
        for reader in self._readers:
            reader.start()

    def results(self) -> dict[str, dict[str, object]]:
        """Waits for all sessions; fails if one takes too long or the learner crashes."""
        results: dict[str, dict[str, object]] = {}
        mode = "none"
        while True:
            try:
                line = self._lines.get(timeout=_SESSION_SECONDS)
            except queue.Empty:
                self._process.kill()
                pytest.fail(f"{mode}: the learner takes longer than {_SESSION_SECONDS} s")
            if not line:
                break
            if line.startswith("begin "):
                mode = line.split()[1]
            else:
                results[mode] = json.loads(line)
        for reader in self._readers:
            reader.join()
        _, status, usage = os.wait4(self._process.pid, 0)
        self._process.returncode = os.waitstatus_to_exitcode(status)
        assert self._process.returncode == 0, f"{mode}: {self._errors[-4000:]}"
        assert usage.ru_maxrss < _MEMORY_KIB_MAX
        return results

    def _read(self) -> None:
        for line in self._process.stdout:
            self._lines.put(line)
        self._lines.put("")

    def _read_errors(self) -> None:
        self._errors = self._process.stderr.read()


@pytest.fixture(scope="module")
def server() -> Iterator[ServerProcess]:
    """A real server."""
    with ServerProcess(flags=["--workers=2"]) as process:
        yield process


def _against(server: ServerProcess, modes: list[str], encoding: str = "raw") -> dict:
    between = {mode: HostileServer(mode, server.address) for mode in modes}
    addresses = {mode: each.address for mode, each in between.items()}
    try:
        return _Run({"unchanged": server.address} | addresses, encoding).results()
    finally:
        for each in between.values():
            each.stop()


@pytest.mark.parametrize("encoding", _ENCODINGS)
def test_invalid_stream_responses_are_errors(server: ServerProcess, encoding: str) -> None:
    modes = (
        hostile_answers.STREAM_ERRORS if encoding == "raw" else hostile_answers.ENCODED_ERRORS
    )
    results = _against(server, modes, encoding)
    right = results.pop("unchanged")["digest"]
    for mode in modes:
        is_right = mode in _OVERLOOKED and results[mode].get("digest") == right
        assert results[mode].get("message") or is_right, (mode, results[mode])


def test_invalid_unary_responses_are_errors(server: ServerProcess) -> None:
    results = _against(server, hostile_answers.UNARY_ERRORS)
    assert "digest" in results.pop("unchanged")
    for mode in hostile_answers.UNARY_ERRORS:
        assert results[mode].get("message"), (mode, results[mode])


@pytest.mark.parametrize("encoding", _ENCODINGS)
def test_mutated_responses_are_errors_or_batches(server: ServerProcess, encoding: str) -> None:
    results = _against(server, mutated_answers.modes(_MUTATION_COUNT), encoding)
    assert "digest" in results["unchanged"]
    for mode, result in results.items():
        # A different value, such as another reward, is a valid response.
        assert result.get("message") or "digest" in result, (mode, result)


def test_fields_of_later_servers_are_ignored(server: ServerProcess) -> None:
    results = _against(server, hostile_answers.STREAM_HARMLESS)
    digests = {result.get("digest") for result in results.values()}
    assert digests == {results["unchanged"]["digest"]}, results


def test_broken_connections_are_errors_or_reconnects(
    server: ServerProcess,
) -> None:
    modes = [mode for mode in FRAMES if mode not in _UNSEEN]
    addresses = {mode: HostileConnection(mode, server.address).address for mode in modes}
    others = {mode: HostileServer(mode, server.address) for mode in _TOLERATED}
    addresses |= {mode: each.address for mode, each in others.items()}
    results = _Run({"unchanged": server.address} | addresses).results()
    right = results.pop("unchanged")["digest"]
    for mode, result in results.items():
        assert result.get("message") or result.get("digest") == right, (mode, result)
    for each in others.values():
        each.stop()
