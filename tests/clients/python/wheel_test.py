"""The wheel is built without a network, has all that it needs, and steps after installation."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

_ROOT = Path(__file__).resolve().parents[3]
_OFFLINE = ["--no-index", "--no-deps", "--disable-pip-version-check"]
_PROGRAM = (Path(__file__).parent / "wheel_program.py").resolve()


def _run(*command: str | Path, **variables: str) -> str:
    without = ("PYTHONPATH", "PROCGEN_LIBRARY")
    inherited = {name: value for name, value in os.environ.items() if name not in without}
    run = subprocess.run(
        command, env=inherited | variables, capture_output=True, text=True, check=False, cwd="/"
    )
    assert run.returncode == 0, run.stdout + run.stderr
    return run.stdout


def _build(output: Path, checkout: Path) -> Path:
    """Builds a wheel from a copy, because the build leaves files in the tree."""
    generated = shutil.ignore_patterns("_proto", "__pycache__", "build", "*.egg-info")
    for folder in ("proto", "clients/c", "clients/python"):
        shutil.copytree(_ROOT / folder, checkout / folder, ignore=generated)
    shutil.copy2(_ROOT / "LICENSE", checkout)
    built = Path(os.environ["PROCGEN_LIBRARY"]).parent
    pip = [sys.executable, "-m", "pip", "wheel", "--no-build-isolation", *_OFFLINE]
    _run(*pip, "--wheel-dir", output, checkout / "clients/python",
         PROCGEN_WHEEL_LIBRARIES=str(built), SOURCE_DATE_EPOCH="1577836800")  # fmt: skip
    (file,) = output.iterdir()
    return file


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return _build(tmp_path_factory.mktemp("wheel"), tmp_path_factory.mktemp("checkout"))


def test_one_wheel_is_for_every_python(wheel: Path) -> None:
    name = r"procgen_server-[\d.]+-py3-none-manylinux_2_\d+_(x86_64|aarch64)\.whl"
    assert re.fullmatch(name, wheel.name), wheel.name


def test_the_wheel_contains_the_modules_the_library_and_licenses(wheel: Path) -> None:
    names = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    sources = {
        str(path.relative_to(_ROOT / "clients/python"))
        for path in (_ROOT / "clients/python/procgen_client").rglob("*.py*")
        if "__pycache__" not in path.parts
    }
    others = ("procgen_client/_vendor/", "procgen_client/licenses/", "procgen_client/libs/")
    own = {name for name in names if not name.startswith(others)}
    assert own - {"procgen_client/libprocgen_remote.so.1"} == sources | {
        "procgen_client/py.typed",
        "procgen_client/libprocgen.so.1",
        "procgen_client/procgen.h",
        "procgen_client/adapters/_xla.c",
    }
    assert {"procgen_client/licenses/procgen-server", "procgen_client/licenses/zlib1g-dev"} < names
    assert "procgen_client/_vendor/google/protobuf/message.py" in names


def test_the_metadata_needs_numpy_alone(wheel: Path) -> None:
    archive = zipfile.ZipFile(wheel)
    (name,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
    metadata = archive.read(name).decode()
    needed = re.findall(r"^Requires-Dist: (.*)$", metadata, re.MULTILINE)
    assert [line.split()[0] for line in needed if "extra ==" not in line] == ["numpy"]


@pytest.mark.slow
def test_two_builds_are_equal(wheel: Path, tmp_path: Path) -> None:
    again = _build(tmp_path / "wheel", tmp_path / "checkout")
    assert again.name == wheel.name
    assert again.read_bytes() == wheel.read_bytes()


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
    assert "error: building the wheel needs protoc; on Debian: apt" in output


def test_an_installed_wheel_steps_in_the_process(wheel: Path, tmp_path: Path) -> None:
    venv.create(tmp_path, with_pip=False, system_site_packages=True)  # with the system's numpy
    python = tmp_path / "bin/python"
    _run(python, "-m", "pip", "install", *_OFFLINE, wheel)
    assert "(64, 64, 64, 3)" in _run(python, _PROGRAM)
    _run(tmp_path / "bin/procgen-evaluate", "--help")
    _run(tmp_path / "bin/procgen-dataset", "--help")
