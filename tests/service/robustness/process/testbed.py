"""Runs procgen-server as another user, with a given log, or with a wall clock that a test sets."""

from __future__ import annotations

import contextlib
import os
import re
import resource
import signal
import struct
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import IO

# Longer than any wait of these tests, on the slowest machine and under sanitizers.
TIMEOUT_S = 60.0
# Maximum time for shutdown after the drain of a second, as server/README.md documents.
STOP_GRACE_S = 10.0
# Maximum number of processes of a user, in the form that prlimit takes.
_HARD_LIMIT = resource.getrlimit(resource.RLIMIT_NPROC)[1]
_PROCESS_COUNT_MAX = "unlimited" if _HARD_LIMIT == resource.RLIM_INFINITY else str(_HARD_LIMIT)


def binary() -> str:
    """The path in PROCGEN_SERVER_BINARY, else the newest build of this checkout."""
    if "PROCGEN_SERVER_BINARY" in os.environ:
        return os.environ["PROCGEN_SERVER_BINARY"]
    found = list(Path(__file__).resolve().parents[4].glob("build/*/bin/procgen-server"))
    assert found, "no procgen-server was built"
    return str(max(found, key=lambda path: path.stat().st_mtime))


def wait_until(is_so: Callable[[], object], what: str, timeout_s: float = TIMEOUT_S) -> None:
    """Polls `is_so` until it is true; fails after `timeout_s`."""
    end = time.monotonic() + timeout_s
    while not is_so():
        assert time.monotonic() < end, f"{what}: not within {timeout_s:g} s"
        time.sleep(0.02)


class Server:
    """A procgen-server process that listens, or has ended."""

    def __init__(
        self, process: subprocess.Popen[bytes], log_path: Path | None, prefix: Sequence[str]
    ) -> None:
        self.process = process
        self._prefix = prefix
        self.log_path = log_path
        assert process.stdout is not None
        line = process.stdout.readline().decode().strip()
        self.address = line.removeprefix("listening on ")

    def log(self) -> str:
        """The content of the log file."""
        assert self.log_path is not None
        return self.log_path.read_text()

    def log_field(self, name: str) -> str:
        """The value of a field of the log event `listening`."""
        found = re.search(rf'event=listening .*\b{name}=("[^"]*"|\S+)', self.log())
        assert found is not None, self.log()
        return found.group(1).strip('"')

    def thread_count(self) -> int:
        return len(os.listdir(f"/proc/{self.process.pid}/task"))

    def allow_threads(self, more: int | None) -> None:
        """Limits the server to `more` additional threads; None: no limit."""
        most = _PROCESS_COUNT_MAX if more is None else str(self.thread_count() + more)
        user = self._prefix  # the owner may change the limit
        command = [*user, "prlimit", f"--pid={self.process.pid}", f"--nproc={most}:"]
        subprocess.run(command, check=True)

    def is_alive(self) -> bool:
        return self.process.poll() is None

    def stop(self, within_s: float = TIMEOUT_S) -> int:
        """Sends SIGTERM; returns the exit status, negative if a signal ended the process."""
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(within_s)


@contextlib.contextmanager
def run(
    *flags: str,
    log_path: Path | None = None,
    log: int | IO[bytes] | None = None,
    prefix: Sequence[str] = (),
    environment: dict[str, str] | None = None,
) -> Iterator[Server]:
    """Runs the program. `log`: its standard error, unless `log_path` is given."""
    with contextlib.ExitStack() as stack:
        if log_path is not None:
            log = stack.enter_context(open(log_path, "wb"))
        process = subprocess.Popen(
            [*prefix, binary(), "--address=127.0.0.1:0", *flags],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=log,
            env={**os.environ, **(environment or {})},
        )
        try:
            yield Server(process, log_path, prefix)
        finally:
            process.kill()
            process.wait()
            assert process.stdout is not None
            process.stdout.close()


class WallClock:
    """The wall clock of processes that run with the variables in `environment`."""

    def __init__(self, folder: Path) -> None:
        self._file = folder / "wall_clock"
        self._file.write_bytes(bytes(8))
        sanitizer = os.environ.get("ASAN_OPTIONS", "")
        self.environment = {
            "LD_PRELOAD": os.environ["PROCGEN_WALL_CLOCK"],
            "PROCGEN_WALL_CLOCK_FILE": str(self._file),
            # AddressSanitizer's library is not the first one then.
            "ASAN_OPTIONS": ":".join(filter(None, [sanitizer, "verify_asan_link_order=0"])),
        }

    def move(self, seconds: int) -> None:
        """Sets the offset from the machine's clock."""
        with self._file.open("r+b") as file:
            file.write(struct.pack("=q", seconds * 10**9))
