"""Packages that a user would install instead, from the Python package index."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path


class ProcgenPackage:
    """The wheel of Procgen 0.10.7 (upstream) in a folder. Its library needs no Python."""

    def __init__(self, packages: Path) -> None:
        """Says where it is. `packages`: the folder that keeps what is fetched."""
        self._packages = packages
        self.library = packages / "procgen/data/prebuilt/libenv.so"
        self.images = packages / "procgen/data/assets"

    def fetch(self) -> str:
        """Fetches it if it is not there. Returns why it cannot be had, empty if it is there."""
        if self.library.exists():
            return ""
        error = _pip(
            "download", "--no-deps", "--only-binary=:all:", "--python-version=3.10",
            "--platform=manylinux2014_x86_64", "--dest", self._packages, "procgen==0.10.7",
        )  # fmt: skip
        for wheel in self._packages.glob("procgen-*.whl"):
            zipfile.ZipFile(wheel).extractall(self._packages)
        return error


class EnvpoolPackage:
    """EnvPool, for this interpreter."""

    def __init__(self, packages: Path) -> None:
        """Says where it is. `packages`: the folder that keeps what is fetched."""
        self.folder = packages / "envpool"  # For PYTHONPATH.

    def fetch(self) -> str:
        """Fetches it if it is not there. Returns why it cannot be had, empty if it is there."""
        if (self.folder / "envpool").exists():
            return ""
        return _pip("install", "--target", self.folder, "envpool")


def _pip(*arguments: str | Path) -> str:
    """Runs pip. Returns its error, empty if there is none."""
    run = subprocess.run([sys.executable, "-m", "pip", *arguments, "--quiet"],
                         capture_output=True, text=True, check=False)  # fmt: skip
    if not run.returncode:
        return ""
    return (run.stderr.strip().splitlines() or [f"pip ended with status {run.returncode}"])[-1]
