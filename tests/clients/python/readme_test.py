"""The examples of the READMEs and of the guides run; only addresses are replaced."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from conftest import server_binary

import procgen_client
from procgen_client import ServerProcess

_PYTHON = Path(__file__).resolve().parents[3] / "clients/python"


def _examples_in(path: Path) -> list[str]:
    return re.findall(r"^```python\n(.*?)^```$", path.read_text(), re.DOTALL | re.MULTILINE)


_EXAMPLES = _examples_in(_PYTHON / "README.md")
_ROOT_EXAMPLES = _examples_in(_PYTHON.parents[1] / "README.md")
_GUIDES = [
    pytest.param(example, id=f"{path.stem}-{i}")
    for path in sorted((_PYTHON / "guides").glob("*.md"))
    for i, example in enumerate(_examples_in(path))
]


def test_documents_have_examples() -> None:
    assert len(_EXAMPLES) >= 5
    assert len(_ROOT_EXAMPLES) >= 1
    assert len(_GUIDES) >= 5


def test_module_docstring_names_every_public_class_and_runs(server: ServerProcess) -> None:
    manual = procgen_client.__doc__
    assert manual is not None
    described = {"ACTION_COUNT", "ACTION_MIN", "AutoresetMode", "ENV_NAMES", "Episode", "connect"}
    for name in set(procgen_client.__all__) - described:
        assert f"`{name}`" in manual, name
    blocks = re.findall(r"::\n\n((?:    .*\n|\n)+)", manual)
    assert len(blocks) == 2
    names: dict[str, object] = {"__name__": "example", "Pool": procgen_client.Pool}
    for block in blocks:
        source = textwrap.dedent(block).replace('"localhost:50051"', repr(server.address))
        exec(compile(source, "procgen_client", "exec"), names)


@pytest.mark.parametrize("example", [*_EXAMPLES, *_ROOT_EXAMPLES, *_GUIDES])
def test_example_runs(
    server: ServerProcess, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, example: str
) -> None:
    if "import torch" in example:
        pytest.importorskip("torch")
    monkeypatch.chdir(tmp_path)
    # Examples without a server address step in this process.
    source = example.replace("localhost:50051", server.address).replace(":8080", ":0")
    assert "localhost" not in source
    for _ in range(2 if "checkpoint" in example else 1):  # The second run resumes the first.
        exec(compile(source, "example", "exec"), {"__name__": "example"})


def test_resumed_training_equals_an_uninterrupted_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    example, _ = _examples_in(_PYTHON / "guides/checkpoint-and-resume.md")

    def output_of(folder: str, source: str, runs: int) -> str:
        (tmp_path / folder).mkdir()
        monkeypatch.chdir(tmp_path / folder)
        capsys.readouterr()
        for _ in range(runs):
            exec(compile(source, "example", "exec"), {"__name__": "example"})
        return capsys.readouterr().out

    whole = output_of("whole", example.replace("update + 6", "update + 11"), 1)
    assert len(whole.splitlines()) == 10
    assert output_of("resumed", example, 2) == whole


def test_replay_example_repeats_an_episode_after_an_incomplete_level(
    server: ServerProcess,
) -> None:
    # Level 52 of miner is complete at its start. After an incomplete level, the exit is closed for
    # one step: the second episode continues where a new environment ends.
    guide = _examples_in(_PYTHON / "guides/watch-and-evaluate.md")
    (example,) = (each for each in guide if "replay" in each)
    source = example.replace("localhost:50051", server.address).replace('"coinrun"', '"miner"')
    source = source.replace('"easy"}', '"easy", "start_level": 52, "num_levels": 1}')
    recorded = """
    for actions in ([-1] * 4, [4] * 4, [4] * 4, [-1] * 4):
        pool.step(actions)
    episode = client.get_episode(pool, 3)
    assert (len(episode.actions), episode.prev_level_incomplete) == (3, True)
"""
    pattern = r"\n    episode = client.get_episode\(pool, 3\).*\n"
    source, count = re.subn(pattern, lambda _: recorded, source)
    assert count == 1
    exec(compile(source, "example", "exec"), {"__name__": "example"})


def test_restart_example_survives_a_restart(tmp_path: Path) -> None:
    guide = _examples_in(_PYTHON / "guides/checkpoint-and-resume.md")
    (example,) = (each for each in guide if "UnavailableError" in each)
    address = f"unix:{tmp_path}/socket"
    source = example.replace("localhost:50051", address)
    with (
        ServerProcess(server_binary(), ["--workers=1"], address=address) as lost,
        subprocess.Popen(
            [sys.executable, "-c", source],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            cwd=tmp_path,
        ) as learner,
    ):
        assert learner.stdout is not None
        assert learner.stdout.readline() == "1 updates\n"
        os.kill(lost.process_id, signal.SIGKILL)
        (tmp_path / "socket").unlink(missing_ok=True)
        with ServerProcess(server_binary(), ["--workers=1"], address=address):
            output, error = learner.communicate()
        assert learner.returncode == 0, error
        assert output == "".join(f"{update} updates\n" for update in range(2, 21))
