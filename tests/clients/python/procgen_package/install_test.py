"""The package `procgen` never changes or hides an installed one of that name."""

from __future__ import annotations

import os
import shutil
import subprocess
import venv
from pathlib import Path

import pytest

_PACKAGE = Path(__file__).resolve().parents[4] / "clients/python/procgen_package"
_OFFLINE = ["--no-index", "--no-deps", "--disable-pip-version-check"]
_WHERE = "import procgen, procgen.env; print(procgen.__file__, len(procgen.env.ENV_NAMES))"


def _run(*command: str | Path, **variables: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command, env=os.environ | variables, capture_output=True, text=True, check=False, cwd="/"
    )


@pytest.fixture
def python(tmp_path: Path) -> Path:
    """The interpreter of an environment with the system's packages."""
    venv.create(tmp_path / "environment", with_pip=False, system_site_packages=True)
    return tmp_path / "environment/bin/python"


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A copy of the package, because the build leaves files in the tree."""
    ignored = shutil.ignore_patterns("build", "*.egg-info", "__pycache__")
    return shutil.copytree(_PACKAGE, tmp_path / "package", ignore=ignored)


def _install_upstream(python: Path) -> Path:
    """Installs a distribution procgen with an empty package; returns the package's folder."""
    (site,) = python.parents[1].glob("lib/python*/site-packages")
    (site / "procgen").mkdir()
    (site / "procgen/__init__.py").write_text("")
    (site / "procgen-0.10.7.dist-info").mkdir()
    (site / "procgen-0.10.7.dist-info/METADATA").write_text("Name: procgen\nVersion: 0.10.7\n")
    return site / "procgen"


def _pip(python: Path, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    return _run(python, "-m", "pip", *arguments, *_OFFLINE)


def test_it_is_installed_in_a_folder_of_its_own(python: Path, checkout: Path) -> None:
    run = _pip(python, "install", "--no-build-isolation", checkout)
    assert run.returncode == 0, run.stdout + run.stderr
    run = _run(python, "-c", _WHERE)
    assert run.stdout.endswith("site-packages/procgen_server_procgen/procgen/__init__.py 16\n")
    run = _run(python, "-m", "pip", "show", "--files", "procgen-server-procgen")
    files = run.stdout.partition("Files:\n")[2].split()
    assert "procgen_server_procgen.pth" in files
    assert all(name.startswith("procgen_server_procgen") for name in files), files


def test_the_build_fails_where_upstream_is_installed(python: Path, checkout: Path) -> None:
    _install_upstream(python)
    run = _pip(python, "install", "--no-build-isolation", checkout)
    assert run.returncode != 0
    expected = "error: the distribution procgen 0.10.7 is installed, and Python finds its package"
    assert expected in run.stdout + run.stderr


def test_upstream_is_found_first(python: Path, checkout: Path, tmp_path: Path) -> None:
    _pip(python, "wheel", "--no-build-isolation", "--wheel-dir", tmp_path / "wheel", checkout)
    (wheel,) = (tmp_path / "wheel").iterdir()
    installed = _install_upstream(python)
    run = _pip(python, "install", wheel)
    assert run.returncode == 0, run.stdout + run.stderr
    run = _run(python, "-c", "import procgen; print(procgen.__file__)")
    assert run.stdout == f"{installed}/__init__.py\n"
    assert (installed / "__init__.py").read_text() == ""


def test_importing_it_beside_upstream_is_an_error(python: Path) -> None:
    _install_upstream(python)
    path = os.pathsep.join([os.environ["PYTHONPATH"], str(_PACKAGE)])
    run = _run(python, "-c", "import procgen", PYTHONPATH=path)
    assert run.returncode != 0
    assert "the distribution procgen 0.10.7 is installed, which has a package" in run.stderr
