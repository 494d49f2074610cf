"""The images of deploy/containers: built on a local Debian root, run, stepped and stopped.

Uses no image registry. The results of the Dockerfile's build stage come from this build.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from procgen_client import Client, errors

_SOURCE = Path(__file__).resolve().parents[2]
_PACKAGES = Path(os.environ["PROCGEN_PACKAGES"])
_BASE = "localhost/debian-slim"
_SERVER_OVER_BASE_MB_MAX = 60
# Excluded as in Debian's slim image.
_LEFT_OUT = ("doc", "info", "locale", "man")
# Containers cannot exceed this machine's limits.
_LIMITS = ("--ulimit", "nofile=4096:4096", "--ulimit", "nproc=4096:4096")


class Containers:
    """Images and containers in a temporary folder."""

    def __init__(self, folder: Path) -> None:
        self._store = ("--root", str(folder / "store"), "--runroot", str(folder / "run"))

    def buildah(self, *arguments: str | Path) -> str:
        """Runs buildah; returns its output."""
        return _output("buildah", *self._store, *arguments)

    def podman(self, *arguments: str | Path) -> str:
        """Runs podman; returns its output."""
        how = ("--runtime", "runc", "--cgroup-manager", "cgroupfs")
        return _output("podman", *self._store, *how, *arguments)

    def run(self, *arguments: str | Path) -> str:
        """Runs a read-only container without a network."""
        strict = ("--read-only", "--cap-drop", "all", "--security-opt", "no-new-privileges")
        return self.podman("run", "--network", "none", *strict, *_LIMITS, *arguments)

    def megabytes(self, image: str) -> float:
        """The unpacked size of an image, including its base images."""
        return int(self.podman("image", "inspect", "--format", "{{.Size}}", image)) / 1e6


def _output(*command: str | Path) -> str:
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, f"{command}\n{result.stdout}{result.stderr}"
    return result.stdout.strip()


@pytest.fixture(scope="module")
def containers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Containers]:
    """Containers with the Debian base image."""
    for program in ("mmdebstrap", "buildah", "podman", "runc"):
        if shutil.which(program) is None:
            pytest.skip(f"there is no {program}; deploy/install-dependencies.sh --slow installs it")
    if os.geteuid() != 0:
        pytest.skip("making a root of Debian needs root")
    folder = tmp_path_factory.mktemp("containers")
    root = folder / "debian.tar"
    left_out = [f"--dpkgopt=path-exclude=/usr/share/{name}/*" for name in _LEFT_OUT]
    _output("mmdebstrap", "--quiet", "--variant=minbase", *left_out, "bookworm", root)
    made = Containers(folder)
    made.podman("import", "--quiet", root, _BASE)
    try:
        made.run("--rm", _BASE, "true")
    except AssertionError as error:
        pytest.skip(f"podman cannot run containers here: {error}")
    yield made
    made.podman("system", "reset", "--force")


@pytest.fixture(scope="module")
def packages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The output of the Dockerfile's build stage, from this build."""
    folder = tmp_path_factory.mktemp("packages")
    for package in _PACKAGES.glob("*.deb"):
        shutil.copy(package, folder)
    shutil.copytree(_SOURCE / "clients/python/procgen_client", folder / "procgen_client")
    for library in ("PROCGEN_LIBRARY", "PROCGEN_REMOTE_LIBRARY"):
        shutil.copy(os.environ[library], folder / "procgen_client")
    return folder


@pytest.fixture(scope="module")
def images(containers: Containers, packages: Path) -> dict[str, str]:
    """Image names by Dockerfile target."""
    names = {target: f"localhost/procgen-{target}" for target in ("server", "learner")}
    for target, name in names.items():
        containers.buildah(
            *("build", "--isolation", "chroot", "--pull=never", "--target", target, "--tag", name),
            *("--build-arg", f"DEBIAN_IMAGE={_BASE}", "--build-context", f"packages={packages}"),
            *("--file", _SOURCE / "deploy/containers/Dockerfile", _SOURCE),
        )
    return names


@pytest.fixture
def socket(containers: Containers, images: dict[str, str], tmp_path: Path) -> Iterator[Path]:
    """The socket of a server container, which is removed afterwards."""
    folder = tmp_path / "socket"
    folder.mkdir()
    folder.chmod(0o777)  # The server runs as another user.
    containers.run(
        *("--detach", "--name", "server", "--volume", f"{folder}:/run/procgen"),
        *(images["server"], "--address=unix:/run/procgen/server"),
    )
    try:
        yield folder / "server"
    finally:
        containers.podman("rm", "--force", "server")


def await_client(socket: Path) -> Client:
    deadline = time.monotonic() + 30
    while True:
        try:
            return Client(f"unix:{socket}", timeout=5)
        except errors.UnavailableError:
            if time.monotonic() > deadline:
                raise


def test_the_server_serves_and_drains(containers: Containers, socket: Path) -> None:
    with await_client(socket) as client, client.create_pool("maze", 4) as pool:
        assert pool.step([4] * 4).observations.shape == (4, 64, 64, 3)
    containers.podman("stop", "--time", "30", "server")
    state = containers.podman("inspect", "--format", "{{.State.ExitCode}}", "server")
    assert state == "0"


def test_the_server_is_unprivileged(containers: Containers, socket: Path) -> None:
    await_client(socket).close()
    shell = ("exec", "server", "sh", "-c")
    assert containers.podman(*shell, "id -u") == "10001"
    assert "Read-only" in containers.podman(*shell, "touch /etc/x 2>&1; true")
    status = containers.podman(*shell, "cat /proc/1/status")
    assert re.search(r"^CapBnd:\s+0+$", status, re.MULTILINE)


def test_a_learner_steps_a_server(
    containers: Containers, images: dict[str, str], socket: Path
) -> None:
    await_client(socket).close()
    said = containers.run(
        *("--rm", "--volume", f"{socket.parent}:/run/procgen", images["learner"]),
        *("--server=unix:/run/procgen/server", "--environments=4", "--seconds=1"),
    )
    assert re.search(r"^[1-9][\d,]* steps, [1-9][\d,]* steps/s$", said, re.MULTILINE)


def test_the_server_is_small(containers: Containers, images: dict[str, str]) -> None:
    over_base = containers.megabytes(images["server"]) - containers.megabytes(_BASE)
    assert 5 < over_base < _SERVER_OVER_BASE_MB_MAX
