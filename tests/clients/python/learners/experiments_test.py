"""An experiment runs its grid, resumes, and writes a table and a plot."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("torch")

from learners import checkpoint_file, experiments, report
from learners.run_folder import CHECKPOINT
from procgen_client import Client, ServerProcess

_TINY = ["--total-steps", "512", "--num-envs", "8", "--num-steps", "32", "--chunk-size", "64"]


@pytest.fixture(autouse=True)
def few_episodes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Limits the evaluation to four episodes, and runs of the random agent to twenty."""
    small = experiments.SCALES["small"]._replace(episode_count=4)
    monkeypatch.setitem(experiments.SCALES, "small", small)
    monkeypatch.setattr(experiments, "RANDOM_EPISODE_COUNT", 20)


def _run(name: str, server: ServerProcess, output: Path, *others: str) -> Path:
    command = [name, "--output", str(output), "--server", server.address, *_TINY, *others]
    assert experiments.main(command) == 0
    return output / f"{name}-small"


def test_a_grid_is_run_once(
    server: ServerProcess, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    root = _run("generalization", server, tmp_path, "--games", "bigfish")
    assert "[4/4] bigfish, 1000 levels, seed 0" in capfd.readouterr().out
    table = (root / "table.md").read_text().splitlines()
    assert table[0].startswith("| game | variant | seeds | last tenth of training | train levels |")
    assert [line.split(" | ")[1] for line in table[2:]] == [
        f"{count} levels" for count in (1, 10, 100, 1000)
    ]
    if importlib.util.find_spec("matplotlib"):
        assert (root / "curves.png").read_bytes().startswith(b"\x89PNG")
    written = {path: path.stat().st_mtime_ns for path in root.rglob("*.csv")}
    assert len(written) == 4 * 3
    for checkpoint in root.rglob("checkpoint.pt"):
        checkpoint.unlink()  # The results suffice.
    _run("generalization", server, tmp_path, "--games", "bigfish")
    assert {path: path.stat().st_mtime_ns for path in root.rglob("*.csv")} == written


def test_table_includes_a_random_agent(server: ServerProcess, tmp_path: Path) -> None:
    root = _run("all_games", server, tmp_path, "--games", "bigfish")
    head, _, row = (root / "table.md").read_text().splitlines()
    assert "random agent" in head
    assert row.split(" | ")[2] == "3", "seeds"
    assert " to " in row.split(" | ")[6], "the range of several random runs"


def test_games_without_the_mode_are_not_run(server: ServerProcess, tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="none of these games has mode memory"):
        _run("memory", server, tmp_path, "--games", "bigfish")


@pytest.mark.parametrize(
    ("name", "games"),
    [
        # Those of the scale that have the mode.
        pytest.param("exploration", [], marks=pytest.mark.slow),
        # None of the scale's games has it.
        pytest.param("memory", [], marks=pytest.mark.slow),
        pytest.param("network_size", ["bigfish"], marks=pytest.mark.slow),
        ("rainbow_vs_ppo", ["bigfish"]),
        pytest.param("sample_efficiency", ["bigfish"], marks=pytest.mark.slow),
    ],
)
def test_experiment_runs(
    server: ServerProcess, tmp_path: Path, name: str, games: list[str]
) -> None:
    root = _run(name, server, tmp_path, *(["--games", *games] if games else []))
    rows = (root / "table.md").read_text().splitlines()[2:]
    assert rows
    assert not list(root.rglob("replay.bin")), "a replay has gigabytes"


def test_levels_in_order_are_tested_in_sequences(
    server: ServerProcess, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The levels of a sequence are one episode, and returns are larger."""
    tested = []
    play = experiments.play_episodes

    def recorded(*arguments: Any, **options: Any) -> Any:  # noqa: ANN401
        tested.append((options["num_levels"], options["use_sequential_levels"]))
        return play(*arguments, **options)

    monkeypatch.setattr(experiments, "play_episodes", recorded)
    _run("sequential_levels", server, tmp_path, "--games", "bigfish")
    assert tested == [(1, True), (0, True), (0, True), (0, True)]


def test_run_without_its_last_checkpoint_is_continued(
    server: ServerProcess, tmp_path: Path
) -> None:
    """A killed run has rows after its last checkpoint."""
    command = ("all_games", server, tmp_path, "--games", "bigfish", "--seeds", "1")
    folder = _run(*command, "--total-steps", "256") / "bigfish/PPO/seed0"
    early = (folder / CHECKPOINT).read_bytes()
    root = _run(*command)
    assert (root / "table.md").read_text().splitlines()[2].startswith("| bigfish | PPO | 1 |")
    assert checkpoint_file.load(folder / CHECKPOINT)["step"] == 512
    (folder / CHECKPOINT).write_bytes(early)
    (folder / "test.json").unlink()
    _run(*command)
    assert checkpoint_file.load(folder / CHECKPOINT)["step"] == 512


def test_options_of_the_learners_are_not_abbreviations() -> None:
    given, others = experiments._parser().parse_known_args(["all_games", "--seed", "3"])
    assert given.seeds is None
    assert others == ["--seed", "3"]


def test_each_experiment_has_runs(client: Client) -> None:
    for experiment in experiments.EXPERIMENTS.values():
        for scale in experiments.SCALES.values():
            changed = experiment.change(scale)
            jobs = list(experiments.jobs_of(experiment, changed, Path()))
            assert len({job.folder for job in jobs}) == len(jobs) >= len(changed.games)


def test_table_has_means_and_ranges() -> None:
    steps = np.array([1.0, 2.0])
    runs = [
        report.Run("maze", "PPO", 0, steps, np.array([np.nan, 6.0]), 6.0, 5.0),
        report.Run("maze", "PPO", 1, steps, np.array([4.0, 8.0]), 8.0, 6.0),
        report.Run("coinrun", "PPO", 0, steps, np.array([5.0, 10.0]), 10.0, 7.5),
    ]
    ranges = {"maze": (5.0, 10.0), "coinrun": (5.0, 10.0)}
    assert report.table(runs, ranges, {}).splitlines()[2:] == [
        "| maze | PPO | 2 | 7.00 (6.00 to 8.00) | 7.00 (6.00 to 8.00) | 5.50 (5.00 to 6.00) | "
        "0.40 | 0.10 |",
        "| coinrun | PPO | 1 | 10.00 | 10.00 | 7.50 | 1.00 | 0.50 |",
        "| mean | PPO |  |  |  |  | 0.70 | 0.30 |",
    ]
