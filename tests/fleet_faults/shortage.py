"""Faults of a reachable host: a full disk, a thread limit, a wall clock that is set."""

from __future__ import annotations

import contextlib
import errno
import os
import struct
import subprocess
from pathlib import Path

from network import NotPermittedError

_DISK_BYTES = 64 << 20
_PIDS = Path("/sys/fs/cgroup/pids")
_FILLER = "filler"


class Disk:
    """A disk of 64 MiB, mounted on a folder."""

    def __init__(self, folder: Path) -> None:
        """Mounts it on `folder`.

        Raises:
            NotPermittedError: Mounting is not permitted.
        """
        self._folder = folder
        command = ["mount", "-t", "tmpfs", "-o", f"size={_DISK_BYTES}", "tmpfs", os.fspath(folder)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise NotPermittedError(f"no disk of a test's own: {done.stderr.strip()}")

    def fill(self) -> None:
        """Fills the disk completely."""
        with open(self._folder / _FILLER, "ab", buffering=0) as file:
            for size in (1 << 20, 1):
                try:
                    while True:
                        file.write(bytes(size))
                except OSError as error:
                    if error.errno != errno.ENOSPC:
                        raise

    def free(self) -> None:
        """Undoes fill."""
        (self._folder / _FILLER).unlink(missing_ok=True)

    def close(self) -> None:
        """Unmounts it, even while files are open."""
        subprocess.run(["umount", "-l", os.fspath(self._folder)], check=False)


class ThreadLimit:
    """A control group whose processes can be prevented from starting threads."""

    def __init__(self, name: str) -> None:
        """Creates the group without a limit.

        Raises:
            NotPermittedError: Control groups are not permitted.
        """
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
