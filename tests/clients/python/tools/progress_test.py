"""Progress is a line that is overwritten on a terminal, and lines at intervals elsewhere."""

from __future__ import annotations

import io

import pytest

from procgen_client.tools.progress import ProgressLine, duration


class _Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(("interval_s", "count"), [(float("inf"), 1), (0, 3), (3600, 2)])
def test_lines_without_a_terminal(interval_s: float, count: int) -> None:
    stream = io.StringIO()
    line = ProgressLine("recorded", 2000, interval_s=interval_s, stream=stream)
    for steps in (500, 1000, 2000, 2000):
        line.show(steps)
    lines = stream.getvalue().splitlines()
    assert len(lines) == count
    assert lines[-1].startswith("recorded 2,000 of 2,000 steps, ")
    assert "left" not in lines[-1]


def test_a_terminal_shows_one_line() -> None:
    terminal = _Terminal()
    line = ProgressLine("maze:", 12, unit="episodes", stream=terminal)
    for episodes in (0, 4, 12):
        line.show(episodes, "fast")
    assert "\r\033[Kmaze: 4 of 12 episodes, fast, 0:00:0" in terminal.getvalue()
    assert terminal.getvalue().endswith("12 of 12 episodes, fast\n")
    assert terminal.getvalue().count("\n") == 1


def test_durations_have_hours() -> None:
    assert duration(3723.4) == "1:02:03"
