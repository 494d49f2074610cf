"""A run with a package that has upstream's interface gives the episodes of a run on a server.

The package is procgen_client, which draws with the same art; upstream's package is not needed.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from small_runs import STEPS_OF_UPDATE, options, results, train

from learners import compare_runs, upstream
from procgen_client import ServerProcess


@pytest.fixture(scope="module")
def here(server: ServerProcess, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run on the server."""
    folder = tmp_path_factory.mktemp("here")
    train(folder, server.address)
    return folder


def test_run_with_the_package_equals_run_on_the_server(
    server: ServerProcess,
    here: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setenv("PROCGEN_SERVER", server.address)
    words = options(tmp_path, None)
    assert upstream.main(["--package", "procgen_client", *words]) == 0
    assert results(tmp_path) == results(here)
    assert compare_runs.main([str(here), str(tmp_path)]) == 0
    count = len(compare_runs.read_episodes(here))
    assert f"{count} episodes are equal" in capsys.readouterr().out


def test_run_with_another_seed_differs(
    server: ServerProcess, here: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    train(tmp_path, server.address, seed=1)
    assert compare_runs.main([str(here), str(tmp_path)]) == 1
    assert "then they differ:\nstep " in capsys.readouterr().out


def test_longer_run_starts_with_the_steps_of_the_shorter(
    server: ServerProcess, here: Path, tmp_path: Path
) -> None:
    train(tmp_path, server.address, total_steps=2 * STEPS_OF_UPDATE)
    assert compare_runs.main([str(here), str(tmp_path)]) == 0


def test_missing_episode_is_a_difference() -> None:
    rows = [(8.0, 0.0, 3.0, 1.0, 1.0), (16.0, 1.0, 4.0, 1.0, 2.0), (16.0, 2.0, 4.0, 1.0, 2.0)]
    assert compare_runs.compare(rows, rows[:2]).difference
    assert compare_runs.compare(rows, rows[:1] + rows[2:]).equal_count == 1
    assert not compare_runs.compare(rows[:1], rows).difference


def test_folder_without_episodes_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="episodes.csv"):
        compare_runs.main([str(tmp_path), str(tmp_path)])
