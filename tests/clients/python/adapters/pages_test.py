"""The programs of the pages about other libraries run, where the library is installed."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

_PAGES = Path(__file__).resolve().parents[4] / "clients/python/guides/frameworks"
_OPENENV = "openenv.md"  # Its program needs a server: openenv_test.py.
_PROGRAM = re.compile(r"^```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_PROGRAMS = [
    pytest.param(program, id=f"{path.stem}-{i}")
    for path in sorted(_PAGES.glob("*.md"))
    for i, program in enumerate(_PROGRAM.findall(path.read_text()))
    if path.name != _OPENENV
]


@pytest.mark.parametrize("program", _PROGRAMS)
def test_program_runs(program: str, tmp_path: Path) -> None:
    # Adapters have the names of their libraries, but for Ray's.
    imported = r"^(?:from|import) (?:procgen_client\.adapters\.(?!rllib))?(\w+)"
    for library in re.findall(imported, program, re.MULTILINE):
        pytest.importorskip(library)
    run = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
    )
    assert run.returncode == 0, run.stderr[-4000:]
