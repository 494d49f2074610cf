"""The variants of a comparison with OpenAI's runs are run, continued, and listed."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("torch")

from small_runs import options

from learners import networks, ppo, suspects


def test_variants_are_options_of_ppo_and_each_has_rows(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--total-steps", "106496", "--output", str(tmp_path), "--time-limit", "0"]
    assert suspects.main(words) == 0, "the limit is over before the first run"
    assert "| variant | seeds | step | return |" in capsys.readouterr().out
    assert not list(tmp_path.glob("*/seed*"))
    for variant in suspects.VARIANTS.values():
        assert ppo.parse(options(tmp_path, None, **variant))


def test_runs_side_by_side_are_listed_and_not_repeated(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    words = ["--variants", "default", "pytorch_adam", "--jobs", "2", "--total-steps", "256"]
    words += ["--num-envs", "8", "--num-steps", "32", "--network", "nature"]
    assert suspects.main([*words, "--output", str(tmp_path)]) == 0
    assert "\npytorch_adam, seed 2\n" in capfd.readouterr().out
    written = {path: path.stat().st_mtime_ns for path in tmp_path.glob("*/seed*/checkpoint.pt")}
    assert len(written) == 2 * suspects.SEEDS
    assert (tmp_path / "table.md").read_text().startswith("| variant | seeds |")
    assert suspects.main([*words, "--output", str(tmp_path)]) == 0
    assert {path: path.stat().st_mtime_ns for path in written} == written


def test_runs_are_compared_with_the_published_ones(tmp_path: Path) -> None:
    folder = tmp_path / "default/seed0"
    words = ["--game", "bigfish", "--network", "nature", "--chunk-size", "64", "--epochs", "1"]
    words += ["--num-steps", "128", "--total-steps", "8192", "--output", str(folder)]
    assert ppo.main(words) == 0
    for name in ("progress", "learning"):  # As if it had taken more steps.
        path = folder / f"{name}.csv"
        header, row = path.read_text().splitlines()
        path.write_text(f"{header}\n100000,{row.partition(',')[2]}\n")
    entropy = float(dict(zip(header.split(","), row.split(","), strict=True))["entropy"])
    cells = [cell.strip() for cell in suspects.table(tmp_path).splitlines()[2].split("|")[1:-1]]
    assert cells[:3] == ["default", "1", "100,000"]
    # OpenAI: 2.687 +- 0.00953.
    assert cells[6] == f"{entropy:.4g} ({(entropy - 2.687) / 0.00953:+.1f})"


def test_eager_runs_have_neither_graphs_nor_compilation(monkeypatch: pytest.MonkeyPatch) -> None:
    assert not ppo.parse(["--eager"]).compile
    monkeypatch.setattr(networks, "is_eager", True)
    assert networks.captured(len) is len
