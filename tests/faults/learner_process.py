"""The program learner.py, run on a host."""

from __future__ import annotations

import dataclasses
import json
import os
import selectors
import signal
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from learner_script import Script
from learner_trace import Trace
from network import Network

_ROOT = Path(__file__).resolve().parents[2]


class LearnerError(Exception):
    """The learner failed; the message contains the end of its output."""


class LearnerProcess:
    """A running learner that reports its progress."""

    def __init__(
        self,
        network: Network,
        host: str,
        servers: str,
        script: Script,
        folder: Path,
        *,
        reconnect_timeout: float,
        announce: Iterable[int] = (),
    ) -> None:
        """Starts the process."""
        self._trace_path = folder / "learner.npz"
        self._log_path = folder / "learner.log"
        command = [
            sys.executable,
            os.fspath(_ROOT / "tests/faults/learner.py"),
            f"--server={servers}",
            f"--reconnect_timeout={reconnect_timeout}",
            f"--script={json.dumps(dataclasses.asdict(script))}",
            f"--trace={self._trace_path}",
            f"--announce={json.dumps(sorted(announce))}",
        ]
        with open(self._log_path, "wb") as log:
            self._process: subprocess.Popen[Any] = network.start(
                host,
                command,
                stdout=subprocess.PIPE,
                stderr=log,
                env={**os.environ, "PYTHONPATH": os.fspath(_ROOT / "clients/python")},
            )
        self._unread = b""

    def next_announced(self, timeout: float) -> int | None:
        """Waits for the next announced request; None if the learner ended."""
        assert self._process.stdout is not None
        with selectors.DefaultSelector() as selector:
            selector.register(self._process.stdout, selectors.EVENT_READ)
            while b"\n" not in self._unread:
                if not selector.select(timeout):
                    raise TimeoutError(f"the learner is silent for {timeout:.3g} s{self._words()}")
                piece = os.read(self._process.stdout.fileno(), 4096)
                if not piece:
                    return None
                self._unread += piece
        line, _, self._unread = self._unread.partition(b"\n")
        return int(line.removeprefix(b"at "))

    def pause(self) -> None:
        """Sends SIGSTOP."""
        self._process.send_signal(signal.SIGSTOP)

    def resume(self) -> None:
        """Undoes pause."""
        self._process.send_signal(signal.SIGCONT)

    def trace(self, timeout: float) -> Trace:
        """Waits for the end; returns the trace."""
        try:
            status = self._process.wait(timeout)
        except subprocess.TimeoutExpired as error:
            raise TimeoutError(f"the learner has not ended after {timeout:.3g} s") from error
        if status != 0:
            raise LearnerError(f"the learner ended with status {status}{self._words()}")
        return Trace.load(self._trace_path)

    def _words(self) -> str:
        words = self._log_path.read_text(errors="replace").splitlines()[-15:]
        return "; the end of its output:\n" + "\n".join(words) if words else ""
