"""A run is tested on all levels while it trains."""

from __future__ import annotations

from pathlib import Path

import pytest
from small_runs import STEPS_OF_UPDATE, train

from procgen_client import ServerProcess


def test_tests_are_rows_and_do_not_change_the_training(
    server: ServerProcess, tmp_path: Path
) -> None:
    untested = train(tmp_path / "untested")
    assert not (tmp_path / "untested/test.csv").exists()
    interval = 2 * STEPS_OF_UPDATE
    assert train(tmp_path / "tested", server.address, test_interval=interval) == untested
    header, *rows = (tmp_path / "tested/test.csv").read_text().splitlines()
    assert header == "step,return_mean,length_mean"
    assert [int(row.split(",")[0]) for row in rows] == [512, 1024]
    assert float(rows[-1].split(",")[2]) > 0, "episodes ended"


@pytest.mark.parametrize("lstm", [None, True])
def test_tests_of_a_continued_run_are_those_of_an_uninterrupted_one(
    tmp_path: Path, lstm: bool | None  # noqa: FBT001 - a parameter of the test
) -> None:
    common = {"test_interval": STEPS_OF_UPDATE, "lstm": lstm, "total_steps": 3 * STEPS_OF_UPDATE}
    train(tmp_path / "whole", **common)
    for _ in range(3):
        train(tmp_path / "parts", time_limit=0, resume=True, **common)
    whole, parts = ((tmp_path / name / "test.csv").read_text() for name in ("whole", "parts"))
    assert len(whole.splitlines()) == 4
    assert parts == whole


def test_negative_interval_is_rejected(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        train(tmp_path, test_interval=-1)
    assert "--test-interval is -1; it is at least 0" in capsys.readouterr().err
