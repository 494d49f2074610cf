"""The wheel, on Debians with nothing installed: from there to the first step."""

from __future__ import annotations

import shutil
import subprocess
import time
from pathlib import Path

import pytest
from debian_root import DebianRoot

_ROOT = Path(__file__).resolve().parents[2]
_PROGRAM = _ROOT / "tests/clients/python/wheel_program.py"
_SECONDS_MAX = 120  # with the fetching of Python and NumPy
_INSTALL = (
    "apt-get update && apt-get install --no-install-recommends python3-venv python3-numpy && "
    # NumPy is Debian's: a root has no access to the Python package index on every network.
    "python3 -m venv --system-site-packages venv && venv/bin/pip install --no-index procgen_*.whl"
)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    output = tmp_path_factory.mktemp("wheel")
    subprocess.run([_ROOT / "clients/python/build_wheel.sh", output], check=True)
    (file,) = output.iterdir()
    return file


@pytest.mark.parametrize("suite", ["bookworm", "trixie"])
def test_a_bare_root_steps_in_two_commands(suite: str, wheel: Path, tmp_path: Path) -> None:
    root = DebianRoot(tmp_path / "root", "ca-certificates", suite)
    for file in (wheel, _PROGRAM):
        shutil.copy2(file, root.path / "root")
    begin = time.monotonic()
    with root.mounted():
        for command in (_INSTALL, f"venv/bin/python {_PROGRAM.name}"):
            result = root.run(command, "/root")
            assert result.returncode == 0, result.stdout[-4000:]
    seconds = time.monotonic() - begin
    print(f"{suite}: {seconds:.1f} s from the bare root to the end of the program")
    assert result.stdout.startswith("stepped (64, 64, 64, 3)"), result.stdout
    assert seconds < _SECONDS_MAX
