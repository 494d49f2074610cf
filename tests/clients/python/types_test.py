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


def test_package_and_examples_pass_mypy_which_reports_wrong_use(tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text(_USES_IT_WRONGLY)
    examples = sorted((_PACKAGE / "examples").glob("*.py"))
    assert examples
    run = subprocess.run(
        ["mypy", "--config-file=pyproject.toml", f"--cache-dir={tmp_path}/cache", "procgen_client",
         *examples, program],
        cwd=_PACKAGE,
        capture_output=True,
        text=True,
        check=False,
    )  # fmt: skip
    found = [line for line in run.stdout.splitlines() if ": error: " in line]
    assert not [line for line in found if str(program) not in line]
    assert len(found) == 3, run.stdout
    assert 'incompatible type "int"; expected "str"' in run.stdout
    assert '"num_levels" to "create_pool" of "Client" has incompatible type "str"' in run.stdout
    assert '"Pool" has no attribute "no_such_method"' in run.stdout
    assert (_PACKAGE / "procgen_client/py.typed").is_file()
