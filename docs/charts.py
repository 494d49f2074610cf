"""Bar charts of measurements, as SVG files, from the tables of README files."""

from __future__ import annotations

import html
import re

from markdown import rows_of_table

_BAR, _GAP, _LEFT, _WIDTH = 16, 6, 250, 700
# Readable on light and on dark pages.
_TEXT, _COLORS = "#808080", ("#2f7fd8", "#e07b39", "#4fa35a", "#9a6fd0")


def charts() -> dict[str, str]:
    """Returns each chart by the name of its file."""
    throughput = rows_of_table("README.md", "| game and levels | cores |")
    bars = []
    game = ""
    for row in throughput:
        game = row[0] or game
        for i, place in enumerate(("in the process", "TCP")):
            label = f"{game}, {row[1]} core{'s' * (row[1] != '1')}, {place}"
            bars.append((label, _number(row[3 + i]), i))
    others = rows_of_table("tests/benchmark/README.md", "| | bigfish | coinrun |")[:4]
    compared = [
        (f"{game}, {row[0]}", _number(row[1 + column]), i)
        for column, game in enumerate(("bigfish", "coinrun", "ninja", "maze"))
        for i, row in enumerate(others)
    ]
    return {
        "throughput.svg": _chart("Python: environment steps per second", bars),
        "comparison.svg": _chart("Environment steps per second of CPU time, one core", compared),
    }


def _number(text: str) -> float:
    match = re.fullmatch(r"([\d,.]+)(k?)", text)
    if match is None:
        raise ValueError(f"{text!r} is no number of a table")
    return float(match[1].replace(",", "")) * (1000 if match[2] else 1)


def _chart(title: str, bars: list[tuple[str, float, int]]) -> str:
    highest = max(value for _, value, _ in bars)
    height = 40 + len(bars) * (_BAR + _GAP)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_LEFT + _WIDTH + 90} {height}" '
        f'font-family="sans-serif" font-size="13" fill="{_TEXT}">',
        f'<text x="0" y="18" font-size="15">{html.escape(title)}</text>',
    ]
    for i, (label, value, color) in enumerate(bars):
        y = 34 + i * (_BAR + _GAP)
        width = round(_WIDTH * value / highest, 1)
        parts += [
            f'<text x="{_LEFT - 8}" y="{y + 13}" text-anchor="end">{html.escape(label)}</text>',
            f'<rect x="{_LEFT}" y="{y}" width="{width}" height="{_BAR}" fill="{_COLORS[color]}"/>',
            f'<text x="{_LEFT + width + 6}" y="{y + 13}">{value:,.0f}</text>',
        ]
    return "\n".join([*parts, "</svg>", ""])
