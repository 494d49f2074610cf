"""An experiment runs its grid, resumes, and writes a table and a plot."""

from __future__ import annotations

import importlib.util
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("torch")

from learners import checkpoint_file, experiments, networks, ppo, published
from learners.grid import EXPERIMENTS, SCALES, jobs_of
from learners.options import words_of
from learners.run_folder import CHECKPOINT
from procgen_client import ServerProcess

_TINY = ["--total-steps", "512", "--num-envs", "8", "--num-steps", "32", "--chunk-size", "64"]


def _run(name: str, server: ServerProcess, output: Path, *others: str) -> Path:
    command = [name, "--output", str(output), "--server", server.address, *_TINY, *others]
    assert experiments.main(command) == 0
    return output / f"{name}-small"


def test_a_grid_is_run_once(
    server: ServerProcess, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    root = _run("generalization", server, tmp_path, "--games", "bigfish", "--jobs", "2")
    output = capfd.readouterr().out
    assert "\n[4/4] bigfish, 1000 levels, seed 0\n" in output
    assert "\n[4/4] bigfish, 1000 levels, seed 0: bigfish 512 of 512 steps, " in output
    table = (root / "table.md").read_text().splitlines()
    assert table[0].startswith("| game | variant | seeds | million steps | training | all levels |")
    rows = [line.split(" | ") for line in table[2:]]
    assert [row[1] for row in rows] == [f"{count} levels" for count in (1, 10, 100, 1000)]
    assert all(row[5] != "" for row in rows), "tests on all levels"
    if importlib.util.find_spec("matplotlib"):
        assert (root / "curves.png").read_bytes().startswith(b"\x89PNG")
    written = {path: path.stat().st_mtime_ns for path in root.rglob("*.csv")}
    assert len(written) == 4 * 4
    for checkpoint in root.rglob("checkpoint.pt"):
        checkpoint.unlink()  # The results suffice.
    _run("generalization", server, tmp_path, "--games", "bigfish")
    assert {path: path.stat().st_mtime_ns for path in root.rglob("*.csv")} == written


def test_report_lists_runs_that_are_missing_beside_those_of_openai(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["baseline", "--scale", "easy", "--report", "--output", str(tmp_path)]
    assert experiments.main(command) == 0
    head, _, *rows = capsys.readouterr().out.splitlines()
    cells = [cell.strip() for cell in rows[0].split("|")[1:]]
    assert len(rows) >= 16
    assert cells[:3] == ["bigfish", "PPO", "0"]
    assert cells[4:8] == ["not run", "12.01 ± 0.75", "not run", "4.72 ± 0.69"]
    assert "all levels, OpenAI" in head


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
        pytest.param("recurrence", ["bigfish"], marks=pytest.mark.slow),
        pytest.param("sample_efficiency", ["bigfish"], marks=pytest.mark.slow),
        pytest.param("sequential_levels", ["bigfish"], marks=pytest.mark.slow),
        pytest.param(
            *("suspects", ["bigfish", "--seeds", "1", "--network", "nature"]),
            marks=pytest.mark.slow,
        ),
    ],
)
def test_experiment_runs(
    server: ServerProcess, tmp_path: Path, name: str, games: list[str]
) -> None:
    root = _run(name, server, tmp_path, *(["--games", *games] if games else []))
    rows = (root / "table.md").read_text().splitlines()[2:]
    assert rows
    assert "not run" not in "".join(rows)
    assert not list(root.rglob("replay.bin")), "a replay has gigabytes"


def test_run_without_its_last_checkpoint_is_continued(
    server: ServerProcess, tmp_path: Path
) -> None:
    """A killed run has rows after its last checkpoint."""
    command = ("baseline", server, tmp_path, "--games", "bigfish", "--test-interval", "256")
    folder = _run(*command, "--total-steps", "256") / "bigfish/PPO/seed0"
    early = (folder / CHECKPOINT).read_bytes()
    root = _run(*command)
    assert (root / "table.md").read_text().splitlines()[2].startswith("| bigfish | PPO | 1 |")
    assert checkpoint_file.load(folder / CHECKPOINT)["step"] == 512
    (folder / CHECKPOINT).write_bytes(early)
    _run(*command)
    assert checkpoint_file.load(folder / CHECKPOINT)["step"] == 512


def test_runs_side_by_side_are_saved_at_a_signal_or_the_time_limit(
    server: ServerProcess, tmp_path: Path
) -> None:
    words = ["baseline", "--games", "bigfish", "coinrun", "--output", str(tmp_path), "--jobs", "2"]
    words += [*_TINY[2:], "--network", "nature", "--server", server.address]
    command = [sys.executable, "-m", "learners.experiments", *words]
    process = subprocess.Popen([*command, "--total-steps", "1000000"])
    runs = [tmp_path / "baseline-small" / game / "PPO/seed0" for game in ("bigfish", "coinrun")]
    while process.poll() is None and not all(map(experiments.last_step, runs)):
        time.sleep(0.1)
    process.send_signal(signal.SIGTERM)
    assert process.wait() == 128 + signal.SIGTERM
    saved = [checkpoint_file.load(run / CHECKPOINT)["step"] for run in runs]
    assert min(saved) >= 256
    assert experiments.main([*words, "--report"]) == 0, "no run had its first test"

    assert experiments.main([*words, "--total-steps", "1000000", "--time-limit", "3"]) == 0
    later = [checkpoint_file.load(run / CHECKPOINT)["step"] for run in runs]
    assert all(step > before for step, before in zip(later, saved, strict=True))
    table = (tmp_path / "baseline-small/table.md").read_text()
    assert "| bigfish | PPO | 1 |" in table


def test_options_of_the_learners_are_not_abbreviations() -> None:
    given, others = experiments._parser().parse_known_args(["baseline", "--seed", "3"])
    assert given.seeds is None
    assert others == ["--seed", "3"]


def test_suspects_are_options_of_ppo_without_tests(tmp_path: Path) -> None:
    scale = EXPERIMENTS["suspects"].change(SCALES["small"])
    jobs = list(jobs_of(EXPERIMENTS["suspects"], scale, tmp_path))
    assert [job.seed for job in jobs] == [seed for seed in range(3) for _ in range(8)], "in turns"
    for job in jobs:
        assert ppo.parse(words_of(job.options(scale))).test_interval == 0


def test_suspects_are_compared_with_the_published_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "suspects-small/bigfish/default/seed0"
    words = ["--game", "bigfish", "--network", "nature", "--chunk-size", "64", "--epochs", "1"]
    words += ["--num-steps", "128", "--total-steps", "8192", "--output", str(folder)]
    assert ppo.main(words) == 0
    for name in ("progress", "learning"):  # As if it had taken more steps.
        path = folder / f"{name}.csv"
        header, row = path.read_text().splitlines()
        path.write_text(f"{header}\n100000,{row.partition(',')[2]}\n")
    entropy = float(dict(zip(header.split(","), row.split(","), strict=True))["entropy"])
    capsys.readouterr()
    assert experiments.main(["suspects", "--report", "--output", str(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    cells = [cell.strip() for cell in lines[-2].split("|")[1:-1]]
    assert cells[:3] == ["bigfish, default", "1", "100,000"]
    # OpenAI: 2.687 +- 0.00953.
    place = 3 + published.COLUMNS.index("entropy")
    assert cells[place] == f"{entropy:.4g} ({(entropy - 2.687) / 0.00953:+.1f})"


def test_eager_runs_have_neither_graphs_nor_compilation(monkeypatch: pytest.MonkeyPatch) -> None:
    assert not ppo.parse(["--eager"]).compile
    monkeypatch.setattr(networks, "is_eager", True)
    assert networks.captured(len) is len


@pytest.mark.parametrize("name", EXPERIMENTS)
@pytest.mark.parametrize("scale", SCALES)
def test_each_run_has_a_folder_of_its_own(name: str, scale: str) -> None:
    changed = EXPERIMENTS[name].change(SCALES[scale])
    jobs = list(jobs_of(EXPERIMENTS[name], changed, Path()))
    assert len({job.folder for job in jobs}) == len(jobs) >= len(changed.games)
    for job in jobs:  # Runs on fewer than all levels are tested on all.
        options = job.options(changed)
        assert ("test_interval" in options) == (options["levels"] != 0)


def test_paper_scale_is_that_of_the_paper() -> None:
    def jobs(name: str) -> list[dict[str, Any]]:
        scale = EXPERIMENTS[name].change(SCALES["paper"])
        return [job.options(scale) for job in jobs_of(EXPERIMENTS[name], scale, Path())]

    for name, seeds in (("generalization", 4), ("sequential_levels", 4), ("baseline", 3)):
        assert {options["seed"] for options in jobs(name)} == set(range(seeds))
    assert {options["mode"] for options in jobs("sequential_levels")} == {"easy"}
    sizes = {
        (options.get("width"), options["levels"], options["learning_rate"])
        for options in jobs("network_size")
        if "width" in options
    }
    assert len(sizes) == 6
    assert (4, 0, 2.5e-4) in sizes
    rainbow = next(options for options in jobs("rainbow_vs_ppo") if "replay_size" in options)
    assert (rainbow["num_envs"], rainbow["replay_size"]) == (8 * 64, 8_000_000)
