"""The other test files of this folder, and of learners, with the real packages from their index.

Each group of packages has a virtual environment, in the folder that the variable
PROCGEN_TEST_ENVIRONMENTS names, which is then used again, or in a temporary one. All together have
8 GB. Tests of missing packages skip themselves, so each group names the files that must run.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

_HERE = Path(__file__).resolve().parent
_PROGRAMS = "../procgen_package/programs_test.py"
_ENVS = "../envs/gymnasium_test.py"
_OLDER_ENVS = "../envs/older_gymnasium_test.py"
# Of PyTorch 2, which compiles networks; Debian has 1.13.
_LEARNERS = ("adam", "memory", "networks", "policy_lag", "update")


class Group(NamedTuple):
    """Packages that are installed together, and the tests that need them."""

    files: tuple[str, ...]
    packages: tuple[str, ...]
    python: str = ""  # Version of the interpreter; empty: that of this test.
    build_packages: tuple[str, ...] = ()  # Of packages without wheels.
    variables: tuple[tuple[str, str], ...] = ()  # Of the environment of pip.
    site: str = ""  # Code that every interpreter of the environment runs at its start.


def _gym(version: str, *more: str) -> Group:
    old = ("setuptools<66", "wheel<0.40", "pip<24.1")
    return Group((_PROGRAMS,), ("numpy<2", "pytest", f"gym=={version}", *more), "3.10", old)


_GROUPS = {
    "gym 0.21": _gym("0.21.0", "gym3"),
    "gym 0.22": _gym("0.22.0"),
    "gym 0.23": _gym("0.23.1"),
    "gym 0.26": _gym("0.26.2"),
    "gymnasium 0.29": Group(
        (_PROGRAMS, _OLDER_ENVS), ("numpy<2", "pytest", "gymnasium==0.29.1")
    ),
    "gymnasium": Group(
        ("dm_env_test.py", "jax_test.py", "openenv_test.py", "pages_test.py", _PROGRAMS, _ENVS),
        ("pytest", "gymnasium", "dm-env", "jax", "openenv", "pillow"),
    ),
    "torch": Group(
        (
            *("ray_test.py", "stable_baselines3_test.py", "torchrl_test.py", "pages_test.py"),
            *(f"../learners/{name}_test.py" for name in _LEARNERS),
        ),
        ("pytest", "stable-baselines3", "torchrl", "ray[rllib]", "protobuf"),
    ),
    # Without its own games and its trainer, for which it downloads sources from elsewhere. Version
    # 3.0.0 then uses a name that it has not defined.
    "pufferlib": Group(
        ("pufferlib_test.py", "pages_test.py"),
        ("pytest", "numpy<2", "psutil", "pufferlib==3.0.0"),
        build_packages=("torch", "cython", "setuptools<80", "wheel", "numpy<2"),
        variables=(("NO_OCEAN", "1"), ("NO_TRAIN", "1")),
        site="import builtins; builtins.c_extension_paths = []",
    ),
}


def _run(
    *command: str | Path, cwd: Path | None = None, **variables: str
) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, **variables}
    return subprocess.run(
        command, capture_output=True, text=True, check=False, env=environment, cwd=cwd
    )


def _interpreter(version: str) -> str | Path:
    """Python of this version, in PATH or of pyenv."""
    if not version:
        return sys.executable
    found = sorted(Path.home().glob(f".pyenv/versions/{version}.*/bin/python"))
    if found:
        return found[-1]
    if _run("sh", "-c", f"command -v python{version}").returncode:
        pytest.skip(f"there is no Python {version}")
    return f"python{version}"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The folder of environments."""
    kept = os.environ.get("PROCGEN_TEST_ENVIRONMENTS")
    made = Path(kept) if kept else tmp_path_factory.mktemp("environments")
    yield made
    if not kept:
        _run("rm", "-rf", made)


def _install(group: Group, environment: Path) -> Path:
    python = environment / "bin/python"
    complete = environment / "complete"
    if complete.exists():
        return python
    interpreter = _interpreter(group.python)
    run = _run(interpreter, "-m", "venv", "--clear", environment)
    assert run.returncode == 0, run.stdout + run.stderr
    pip = [python, "-m", "pip", "install", "--quiet"]
    if group.build_packages:
        run = _run(*pip, *group.build_packages)
        assert run.returncode == 0, run.stdout + run.stderr
        pip.append("--no-build-isolation")
    if group.site:
        (packages,) = environment.glob("lib/python*/site-packages")
        (packages / "procgen_test.pth").write_text(group.site)
    run = _run(*pip, *group.packages, **dict(group.variables))
    assert run.returncode == 0, run.stdout + run.stderr
    complete.touch()
    return python


@pytest.mark.parametrize("name", _GROUPS)
def test_tests_pass_with(name: str, folder: Path, tmp_path: Path) -> None:
    group = _GROUPS[name]
    python = _install(group, folder / re.sub(r"\W", "-", name))
    for file in group.files:  # In a folder of their own: PufferLib makes a link in the current one.
        run = _run(python, "-m", "pytest", "-q", "-rs", "-p", "no:cacheprovider", "--noconftest",
                   _HERE / file, cwd=tmp_path)  # fmt: skip
        assert run.returncode == 0, run.stdout + run.stderr
        print(f"{name}: {file}: {run.stdout.splitlines()[-1]}")
