"""The first screen of README.md, word for word, on a Debian with nothing installed."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from debian_root import DebianRoot

_ROOT = Path(__file__).resolve().parents[2]
_README = (_ROOT / "README.md").read_text()
_CHECKOUT = "/procgen-server"


def _section(title: str) -> str:
    match = re.search(rf"^## {title}\n(.*?)^## ", _README, re.DOTALL | re.MULTILINE)
    assert match is not None, title
    return match.group(1)


def _commands(text: str) -> list[str]:
    """The indented lines, without comments."""
    lines = re.findall(r"^    (.+)$", text, re.MULTILINE)
    return [line.split("  #")[0].strip() for line in lines]


def _row(name: str) -> list[str]:
    """The commands of a row of the table of installations."""
    match = re.search(rf"^\| {name} \| (.*) \|$", _section("Install"), re.MULTILINE)
    assert match is not None, name
    return re.findall(r"`(.*?)`", match.group(1))


@pytest.fixture(scope="module")
def debian(tmp_path_factory: pytest.TempPathFactory) -> Iterator[DebianRoot]:
    """A bare Debian with a fresh clone of HEAD."""
    root = DebianRoot(tmp_path_factory.mktemp("bare") / "root", "ca-certificates")
    subprocess.run(
        ["git", "clone", "--quiet", "--no-local", _ROOT, f"{root.path}{_CHECKOUT}"], check=True
    )
    with root.mounted():
        yield root


def _run(debian: DebianRoot, script: str) -> str:
    result = debian.run(script, _CHECKOUT)
    assert result.returncode == 0, f"{script}\n{result.stdout[-4000:]}"
    return result.stdout


def test_quickstart_steps_every_game(debian: DebianRoot) -> None:
    command, _ = _commands(_README.partition("## Install")[0])
    output = _run(debian, command)
    assert re.search(r"^steps/s +in this process +on the server$", output, re.MULTILINE)
    assert (debian.path / "procgen-server/quickstart.png").stat().st_size > 100_000


def test_the_example_steps_in_the_process(debian: DebianRoot) -> None:
    section = _section("Step environments")
    (example,) = re.findall(r"^```python\n(.*?)^```$", section, re.DOTALL | re.MULTILINE)
    (debian.path / "procgen-server/FILE").write_text(f"{example}\nprint(observations.shape)\n")
    command = next(text for text in re.findall(r"`(.*?)`", section) if text.endswith(" FILE"))
    assert _run(debian, command).splitlines()[-1] == "(64, 64, 64, 3)"


def test_the_server_starts(debian: DebianRoot) -> None:
    quickstart, *_, server = _row("source")
    assert quickstart == "deploy/quickstart.sh"
    output = _run(debian, f"timeout --preserve-status --signal=INT 3 {server}")
    assert "event=listening" in output


def test_the_debian_package_is_built_and_installed(debian: DebianRoot) -> None:
    for command in _row("Debian package of the server"):
        _run(debian, command)
    assert "procgen-server" in _run(debian, "procgen-server --version")


def test_the_learner_trains(debian: DebianRoot) -> None:
    install, folder, train = _commands(_section("Train"))
    _run(debian, install)
    output = _run(
        debian, f"{folder} && timeout --preserve-status --signal=TERM 180 {train}; echo status $?"
    )
    assert re.search(r"\d+ steps/s", output), output
    (progress,) = debian.path.glob("procgen-server/clients/python/runs/coinrun/**/progress.csv")
    assert len(progress.read_text().splitlines()) > 1, output


def test_the_wheel_is_built_and_installed(debian: DebianRoot) -> None:
    build, install = _row("Python wheel")
    _run(debian, build)
    _run(debian, "apt-get install python3-venv python3-numpy")
    _run(debian, "/usr/bin/python3 -m venv --system-site-packages venv")
    # The wheel needs numpy, which the system has.
    install = install.replace("pip install", "pip install --no-index")
    _run(debian, f". venv/bin/activate && {install}")
    program = (
        "from procgen_client import ProcgenVectorEnv as E; print(E('coinrun', 64).reset()[0].shape)"
    )
    output = _run(debian, f'cd / && {_CHECKOUT}/venv/bin/python -c "{program}"')
    assert output == "(64, 64, 64, 3)\n"
