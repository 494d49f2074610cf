"""mypy accepts the package, and uses its types to check programs."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

_PACKAGE = Path(__file__).resolve().parents[3] / "clients/python"
_USES_IT_WRONGLY = """
import procgen_client
client = procgen_client.Client(50051)
pool = client.create_pool("maze", num_levels="many")
pool.no_such_method()
"""

pytestmark = pytest.mark.skipif(shutil.which("mypy") is None, reason="mypy is missing")


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """mypy's cache, shared by the tests."""
    return tmp_path_factory.mktemp("cache")


def _mypy(cache: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["mypy", "--config-file=pyproject.toml", f"--cache-dir={cache}", *arguments],
        cwd=_PACKAGE,
        capture_output=True,
        text=True,
        check=False,
    )


def test_package_and_examples_pass_mypy(cache: Path) -> None:
    examples = [str(file) for file in sorted((_PACKAGE / "examples").glob("*.py"))]
    assert examples
    run = _mypy(cache, "procgen_client", *examples)
    assert run.returncode == 0, run.stdout


def test_mypy_reports_wrong_use_of_the_package(cache: Path, tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text(_USES_IT_WRONGLY)
    run = _mypy(cache, str(program))
    assert 'incompatible type "int"; expected "str"' in run.stdout
    assert '"num_levels" to "create_pool" of "Client" has incompatible type "str"' in run.stdout
    assert '"Pool" has no attribute "no_such_method"' in run.stdout
    assert (_PACKAGE / "procgen_client/py.typed").is_file()
