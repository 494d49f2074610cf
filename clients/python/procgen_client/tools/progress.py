"""Progress of long commands."""

from __future__ import annotations

import math
import sys
import time
from typing import IO


class ProgressLine:
    """Prints how much is done, and the time that is left.

    On a terminal one line, which is overwritten; otherwise a line at intervals and one at the end.
    """

    def __init__(
        self,
        name: str,
        total: int,
        *,
        unit: str = "steps",
        interval_s: float = math.inf,
        stream: IO[str] | None = None,
    ) -> None:
        """Takes what is done, how much of it, and the time between two lines; None: stderr."""
        self._name, self._total, self._unit = name, total, unit
        self._interval, self._stream = interval_s, stream or sys.stderr
        self._due = math.inf if interval_s == math.inf else -math.inf
        self._begin: tuple[float, int] | None = None
        self._is_over = False

    def show(self, count: int, text: str = "") -> None:
        """Prints that `count` of the total are done, and `text`, by default the rate."""
        now = time.monotonic()
        if self._is_over:
            return
        self._is_over = count >= self._total
        self._begin = self._begin or (now, count)
        rate = (count - self._begin[1]) / max(now - self._begin[0], 1e-3)
        line = f"{self._name} {count:,} of {self._total:,} {self._unit}"
        line += f", {text or f'{rate:,.0f}/s'}"
        if rate > 0 and not self._is_over:
            line += f", {duration((self._total - count) / rate)} left"
        if self._stream.isatty():
            self._stream.write(f"\r\033[K{line}" + "\n" * self._is_over)
        elif self._is_over or now >= self._due:
            self._due = now + self._interval
            self._stream.write(line + "\n")
        self._stream.flush()


def duration(seconds: float) -> str:
    """Returns e.g. ``1:02:03``."""
    minutes, second = divmod(max(0, round(seconds)), 60)
    hours, minute = divmod(minutes, 60)
    return f"{hours}:{minute:02}:{second:02}"
