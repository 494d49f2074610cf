"""A writable copy of this machine's file system that is discarded with the process."""

from __future__ import annotations

import ctypes
import os
import subprocess
from pathlib import Path

_CLONE_NEWNS = 0x00020000
_CLONE_NEWNET = 0x40000000


class NotPermittedError(Exception):
    """Separate file systems or networks are not permitted."""


class ThrowawayRoot:
    """An overlay over this machine's root, and a network with nothing but loopback.

    This process and its children use both from now on: ports of 127.0.0.1 are free, and servers of
    this machine cannot be reached there.
    """

    def __init__(self, folder: Path) -> None:
        """Creates the overlay in the empty folder `folder`.

        Raises:
            NotPermittedError: The system does not permit it.
        """
        if os.geteuid() != 0:
            raise NotPermittedError("a file system of one's own needs root")
        libc = ctypes.CDLL(None, use_errno=True)
        if libc.unshare(_CLONE_NEWNS | _CLONE_NEWNET) != 0:
            raise NotPermittedError(f"unshare: {os.strerror(ctypes.get_errno())}")
        self.path = folder / "root"
        layers = folder / "layers"
        self.path.mkdir()
        layers.mkdir()
        _mount("--make-rprivate", "/")
        _mount("-t", "tmpfs", "layers", layers)
        upper, work = layers / "upper", layers / "work"
        upper.mkdir()
        work.mkdir()
        _mount(
            *("-t", "overlay", "overlay"),
            *("-o", f"lowerdir=/,upperdir={upper},workdir={work}"),
            self.path,
        )
        for place in ("proc", "dev"):
            _mount("--rbind", f"/{place}", self.path / place)
        for place in ("run", "tmp"):  # Hides a systemd that runs outside.
            _mount("-t", "tmpfs", place, self.path / place)
        _run("ip", "link", "set", "lo", "up")

    def run(self, *command: str, user: str = "root") -> subprocess.CompletedProcess[str]:
        """Runs a command in the overlay."""
        return subprocess.run(
            self._chroot(command, user), capture_output=True, text=True, check=False, cwd="/"
        )

    def start(self, *command: str, user: str) -> subprocess.Popen[str]:
        """Starts a command in the overlay; standard output and error are merged."""
        return subprocess.Popen(
            self._chroot(command, user),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            cwd="/",
        )

    def _chroot(self, command: tuple[str, ...], user: str) -> list[str | Path]:
        return ["chroot", f"--userspec={user}:{user}", self.path, *command]


def _mount(*arguments: str | Path) -> None:
    _run("mount", *arguments)


def _run(*command: str | Path) -> None:
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    if result.returncode != 0:
        raise NotPermittedError(result.stderr.strip())
