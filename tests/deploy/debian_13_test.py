"""Debian 13: the packages are built there from a source archive, and installed on a bare system."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from debian_root import DebianRoot

from procgen_client import Client

_ROOT = Path(__file__).resolve().parents[2]
_SUITE = "trixie"


def _run(debian: DebianRoot, script: str, folder: str = "/") -> str:
    result = debian.run(script, folder)
    assert result.returncode == 0, f"{script}\n{result.stdout[-4000:]}"
    return result.stdout


def _unpack_sources(folder: Path) -> None:
    archive = subprocess.run(
        ["git", "-C", _ROOT, "archive", "HEAD"], check=True, stdout=subprocess.PIPE
    )
    folder.mkdir()
    subprocess.run(["tar", "--extract", "--directory", folder], check=True, input=archive.stdout)


@pytest.fixture(scope="module")
def packages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the packages that Debian 13 builds, as .github/workflows/release.yml."""
    root = DebianRoot(tmp_path_factory.mktemp("build") / "root", "ca-certificates", _SUITE)
    _unpack_sources(root.path / "source")
    with root.mounted():
        _run(root, "deploy/install-dependencies.sh", "/source")
        for command in (
            "cmake --preset release",
            "cmake --build --preset release",
            "cpack --config build/release/CPackConfig.cmake",
            "deploy/release/make_notice.py build/release build/release/packages",
        ):
            _run(root, command, "/source")
    return root.path / "source/build/release/packages"


@pytest.fixture(scope="module")
def debian(packages: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[DebianRoot]:
    """Another root, with both packages installed."""
    root = DebianRoot(tmp_path_factory.mktemp("bare") / "root", "ca-certificates", _SUITE)
    for package in packages.glob("*.deb"):
        shutil.copy(package, root.path / "tmp")
    with root.mounted():
        _run(root, "apt-get update && apt-get install --no-install-recommends /tmp/*.deb")
        yield root


def test_packages_depend_on_the_libraries_of_debian_13(debian: DebianRoot) -> None:
    depends = _run(debian, "dpkg-query --show --showformat='${Depends}' procgen-server")
    assert "libabsl20240722" in depends
    assert "libgrpc++1.51t64" in depends


def test_the_server_serves(debian: DebianRoot) -> None:
    server = subprocess.Popen(
        ["chroot", debian.path, "procgen-server", "--address=127.0.0.1:0"],
        stdout=subprocess.PIPE,
        text=True,
    )
    with server:
        address = re.fullmatch(r"listening on (\S+)\n", server.stdout.readline())[1]
        with Client(address) as client, client.create_pool("coinrun", 2) as pool:
            assert pool.step([7, 7]).observations.shape == (2, 64, 64, 3)
        server.terminate()
    assert server.returncode == 0


def test_a_program_in_c_finds_the_libraries(debian: DebianRoot) -> None:
    shutil.copy(_ROOT / "tests/clients/c/minimal.c", debian.path / "tmp")
    _run(debian, "apt-get install --no-install-recommends gcc libc6-dev pkg-config")
    _run(debian, "gcc minimal.c $(pkg-config --cflags --libs procgen) -o minimal", "/tmp")
    assert "pixels drawn" in _run(debian, "/tmp/minimal")
