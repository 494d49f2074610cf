"""Faults of a reachable host: a thread limit, a wall clock that is set."""

from __future__ import annotations

import contextlib
import os
import struct
from pathlib import Path

from network import NotPermittedError

_PIDS = Path("/sys/fs/cgroup/pids")


class ThreadLimit:
    """A control group whose processes can be prevented from starting threads."""

    def __init__(self, name: str) -> None:
        """Creates the group without a limit."""
        self._group = _PIDS / f"procgen-{os.getpid()}-{name}"
        try:
            self._group.mkdir(exist_ok=True)
        except OSError as error:
            raise NotPermittedError(f"no group of processes: {error}") from error

    def begin(self, process_id: int) -> None:
        """Prevents a process from starting threads."""
        (self._group / "cgroup.procs").write_text(str(process_id))
        count = (self._group / "pids.current").read_text()
        (self._group / "pids.max").write_text(count)

    def end(self) -> None:
        """Undoes begin."""
        (self._group / "pids.max").write_text("max")

    def close(self) -> None:
        """Removes the group, once its processes have ended."""
        with contextlib.suppress(OSError):
            self._group.rmdir()


class WallClock:
    """The wall clock of a process, settable at any time: see tests/wall_clock."""

    def __init__(self, library: Path, path: Path) -> None:
        """Starts with the machine's time. `path`: a file for the offset."""
        self._library = library
        self._path = path
        path.write_bytes(struct.pack("=q", 0))

    @property
    def environment(self) -> dict[str, str]:
        """The environment variables of a process with this clock."""
        return {
            "LD_PRELOAD": os.fspath(self._library),
            "PROCGEN_WALL_CLOCK_FILE": os.fspath(self._path),
        }

    def set(self, seconds: int) -> None:
        """Sets the clock `seconds` ahead of the machine's clock."""
        # A single write to the file that the process has mapped.
        with open(self._path, "r+b", buffering=0) as file:
            file.write(struct.pack("=q", seconds * 1_000_000_000))
