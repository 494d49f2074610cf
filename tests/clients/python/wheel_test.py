"""The wheel is built without a network, contains all modules, and works after installation."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

from procgen_client import ServerProcess

_ROOT = Path(__file__).resolve().parents[3]
_OFFLINE = ["--no-index", "--no-deps", "--disable-pip-version-check"]
_PROGRAM = """
import sys
import procgen_client
from procgen_client import ProcgenVectorEnv
assert "site-packages" in procgen_client.__file__, procgen_client.__file__
with ProcgenVectorEnv("maze", 2, server=sys.argv[1]) as env:
    env.reset()
    env.step([4, 4])
"""


def _run(*command: str | Path) -> str:
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    run = subprocess.run(
        command, env=environment, capture_output=True, text=True, check=False, cwd="/"
    )
    assert run.returncode == 0, run.stdout + run.stderr
    return run.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Built from a copy, because the build leaves files in the tree."""
    checkout = tmp_path_factory.mktemp("checkout")
    generated = shutil.ignore_patterns("_proto", "__pycache__", "build", "*.egg-info")
    for folder in ("proto", "clients/python"):
        shutil.copytree(_ROOT / folder, checkout / folder, ignore=generated)
    shutil.copy2(_ROOT / "LICENSE", checkout)
    output = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "wheel", "--no-build-isolation", *_OFFLINE]
    _run(*pip, "--wheel-dir", output, checkout / "clients/python")
    (file,) = output.iterdir()
    return file


def test_wheel_contains_exactly_the_modules(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    sources = {
        str(path.relative_to(_ROOT / "clients/python"))
        for path in (_ROOT / "clients/python/procgen_client").rglob("*.py*")
        if "__pycache__" not in path.parts
    }
    assert {name for name in names if ".dist-info/" not in name} == sources | {
        "procgen_client/py.typed",
        "procgen_client/licenses/procgen-server",
    }


def test_missing_tools_are_named(tmp_path: Path) -> None:
    run = subprocess.run(
        [sys.executable, "-m", "pip", "wheel", "--no-build-isolation", *_OFFLINE, "--wheel-dir",
         tmp_path, _ROOT / "clients/python"],
        env=os.environ | {"PATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )  # fmt: skip
    assert run.returncode != 0
    output = run.stdout + run.stderr
    assert "error: building the wheel needs protoc, grpc_python_plugin; on Debian: apt" in output
    assert "PROCGEN_WHEEL" not in output  # The pure wheel needs them, too.


def test_missing_protobuf_is_named() -> None:
    program = "import sys; sys.path[:0] = sys.argv[1:]; import bundle; bundle._protobuf_folder()"
    run = subprocess.run(
        # Without installed packages, as in pip's build environment.
        [sys.executable, "-S", "-B", "-c", program, _ROOT / "clients/python"],
        env={name: value for name, value in os.environ.items() if name != "PYTHONPATH"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 1
    assert run.stderr.startswith("error: the wheel needs protobuf"), run.stderr


def test_installed_wheel_works(
    server: ServerProcess, wheel: Path, tmp_path: Path
) -> None:
    # Uses the system's grpcio, protobuf and numpy.
    venv.create(tmp_path, with_pip=False, system_site_packages=True)
    python = tmp_path / "bin/python"
    _run(python, "-m", "pip", "install", *_OFFLINE, wheel)
    _run(python, "-c", _PROGRAM, server.address)
    arguments = ["maze", "--server", server.address, "--episodes", "2", "--environments", "2"]
    assert "| mean |" in _run(tmp_path / "bin/procgen-evaluate", "--mode", "easy", *arguments)
