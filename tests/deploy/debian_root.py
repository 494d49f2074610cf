"""A bare Debian in a folder, with this machine's network: what a newcomer starts with."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest


class DebianRoot:
    """A root file system in `path`, with minimal packages and those of `packages`."""

    def __init__(self, path: Path, packages: str, suite: str = "bookworm") -> None:
        """Fetches and unpacks it; skips the test where that is not permitted."""
        if os.geteuid() != 0:
            pytest.skip("chroot needs root")
        self.path = path
        subprocess.run(
            ["mmdebstrap", "--variant=minbase", f"--include={packages}", suite, path],
            check=True,
        )
        for device in ("null", "urandom"):
            (path / "dev" / device).unlink(missing_ok=True)
            subprocess.run(["cp", "-a", f"/dev/{device}", path / "dev"], check=True)
        for place in ("resolv.conf", "hosts"):
            shutil.copy(f"/etc/{place}", path / "etc" / place)
        # The root is temporary: dpkg need not wait for the disk.
        (path / "etc/dpkg/dpkg.cfg.d/unsafe-io").write_text("force-unsafe-io\n")
        # Nothing answers apt's questions here.
        (path / "etc/apt/apt.conf.d/90yes").write_text('APT::Get::Assume-Yes "true";\n')

    @contextlib.contextmanager
    def mounted(self) -> Iterator[DebianRoot]:
        """With /proc."""
        target = self.path / "proc"
        target.mkdir(exist_ok=True)
        subprocess.run(["mount", "-t", "proc", "proc", target], check=True)
        try:
            yield self
        finally:
            subprocess.run(["umount", "--lazy", target], check=True)

    def run(self, script: str, folder: str = "/") -> subprocess.CompletedProcess[str]:
        """Runs a Bash script as root in `folder`; output and errors are merged."""
        variables = (
            "HOME=/root",
            "PATH=/usr/sbin:/usr/bin:/sbin:/bin",
            "DEBIAN_FRONTEND=noninteractive",
        )
        command = ("bash", "-c", f"cd {folder} && {script}")
        return subprocess.run(
            ["chroot", self.path, "env", "-i", *variables, *command],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
