"""The wheel with everything works on a bare system: Python, numpy and nothing else of ours."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

_ROOT = Path(__file__).resolve().parents[3]
_BYTES_MAX = 25 << 20
(_README_EXAMPLE,) = re.findall(
    r"^```python\n(.*?)^```$", (_ROOT / "README.md").read_text(), re.DOTALL | re.MULTILINE
)
_PROGRAM = f"""
{_README_EXAMPLE}
import procgen_client
from procgen_client._transport import is_native
assert is_native()
assert observations.shape == (64, 64, 64, 3), observations.shape
print("stepped", env.pool.transport, "from", procgen_client.__file__)
"""
_ONE_LINE = (
    "from procgen_client import ProcgenVectorEnv as E; "
    "e = E('coinrun', 64); print(e.reset()[0].shape)"
)


@pytest.fixture(scope="module")
def wheels(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of both wheels."""
    output = tmp_path_factory.mktemp("wheels")
    subprocess.run([_ROOT / "clients/python/build_wheel.sh", output], check=True)
    return output


@pytest.fixture(scope="module")
def bare_root(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A root file system with Python and numpy, and a user without rights."""
    if os.geteuid() != 0:
        pytest.skip("chroot needs root")
    root = tmp_path_factory.mktemp("bare") / "root"
    subprocess.run(
        ["mmdebstrap", "--variant=minbase", "--include=python3-venv,python3-numpy,adduser",
         "bookworm", root],
        check=True,
    )  # fmt: skip
    for device in ("null", "urandom"):
        (root / "dev" / device).unlink(missing_ok=True)
        subprocess.run(["cp", "-a", f"/dev/{device}", root / "dev"], check=True)
    (root / "dev/shm").mkdir(exist_ok=True)
    (root / "dev/shm").chmod(0o1777)
    for place in ("proc", "dev/shm"):
        kind = "proc" if place == "proc" else "tmpfs"
        subprocess.run(["mount", "-t", kind, kind, root / place], check=True)
    _run(root, "adduser --disabled-password --gecos '' learner", user="root")
    yield root
    for place in ("dev/shm", "proc"):
        subprocess.run(["umount", root / place], check=True)


def _run(root: Path, script: str, user: str = "learner") -> str:
    run = subprocess.run(
        ["chroot", root, "su", "-", user, "-c", script], capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stdout + run.stderr
    return run.stdout


def test_wheels_are_named_and_small(wheels: Path) -> None:
    names = sorted(file.name for file in wheels.iterdir())
    assert len(names) == 2, names
    assert re.fullmatch(r"procgen_server-[\d.]+-cp\d+-cp\d+-linux_x86_64\.whl", names[0])
    assert re.fullmatch(r"procgen_server-[\d.]+-py3-none-any\.whl", names[1])
    assert (wheels / names[0]).stat().st_size < _BYTES_MAX


def test_an_empty_environment_steps_a_server_of_its_own(wheels: Path, bare_root: Path) -> None:
    (wheel,) = wheels.glob("*linux_x86_64.whl")
    shutil.copy2(wheel, bare_root / "home/learner")
    (bare_root / "home/learner/program.py").write_text(_PROGRAM)
    _run(
        bare_root,
        "python3 -m venv --system-site-packages venv && "
        f"venv/bin/pip install --no-index {wheel.name}",
    )
    output = _run(bare_root, "venv/bin/python program.py")
    assert output.startswith("stepped shared_memory from "), output
    assert "site-packages" in output
    assert _run(bare_root, f'venv/bin/python -c "{_ONE_LINE}"') == "(64, 64, 64, 3)\n"
    shutil.copy2(_ROOT / "clients/python/examples/random_agent.py", bare_root / "home/learner")
    _run(
        bare_root,
        "venv/bin/procgen-server --address=127.0.0.1:50951 >log 2>&1 & "
        "venv/bin/python random_agent.py 127.0.0.1:50951 coinrun; status=$?; kill $!; exit $status",
    )
    evaluation = "venv/bin/procgen-evaluate maze --mode easy --episodes 2 --environments 2"
    assert "| mean |" in _run(bare_root, evaluation)
    # Abseil's --help exits with status 1, as in procgen-top.
    for command, text in (
        ("procgen-server --help", "hosts pools"),
        ("procgen-server --version", "procgen-server"),
        ("procgen-top --help", "monitors a running procgen-server"),
    ):
        assert text in _run(bare_root, f"venv/bin/{command} || true")
