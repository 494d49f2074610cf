"""The package's types hold by mypy, and programs that use it are checked with them."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

_PACKAGE = Path(__file__).resolve().parents[3] / "clients/python"
_USES_IT_WRONGLY = """
import procgen_client
client = procgen_client.Client(50051)
env = procgen_client.ProcgenEnv1("maze")
env.no_such_method()
"""

pytestmark = pytest.mark.skipif(shutil.which("mypy") is None, reason="mypy is missing")


def _mypy(cache: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["mypy", "--config-file=pyproject.toml", f"--cache-dir={cache}", *arguments],
        cwd=_PACKAGE,
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_package_and_its_examples_are_typed(tmp_path: Path) -> None:
    for arguments in (["-p", "procgen_client"], *([str(file)] for file in _examples())):
        run = _mypy(tmp_path, *arguments)
        assert run.returncode == 0, run.stdout


def test_programs_are_checked_with_them(tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text(_USES_IT_WRONGLY)
    run = _mypy(tmp_path, str(program))
    assert 'incompatible type "int"; expected "str"' in run.stdout
    assert '"ProcgenEnv1" has no attribute "no_such_method"' in run.stdout
    assert (_PACKAGE / "procgen_client/py.typed").is_file()


def _examples() -> list[Path]:
    return sorted((_PACKAGE / "examples").glob("*.py"))
