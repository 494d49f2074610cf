"""Markdown from the comments of source files."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

_SPECIAL = re.compile(r"([\\*_\[\]<>|$])")
_CODE = re.compile(r"(`[^`]+`)")


def escaped(text: str) -> str:
    """Escapes what Markdown would read as markup; `code` stays."""
    parts = _CODE.split(text)
    return "".join(part if i % 2 else _SPECIAL.sub(r"\\\1", part) for i, part in enumerate(parts))


def from_comment(lines: list[str]) -> str:
    """Returns paragraphs of a comment; those with indented lines keep their layout."""
    paragraphs: list[list[str]] = [[]]
    for line in lines:
        if line.strip():
            paragraphs[-1].append(line)
        elif paragraphs[-1]:
            paragraphs.append([])
    blocks = []
    for paragraph in paragraphs:
        if any(line.startswith(" ") for line in paragraph):
            blocks.append("```text\n" + "\n".join(paragraph) + "\n```")
        elif paragraph:
            blocks.append(escaped(" ".join(paragraph)))
    return "\n\n".join(blocks)


def table(head: list[str], rows: list[list[str]]) -> str:
    """Returns a table; the first row's cells are the titles of columns."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


def rows_of_table(path: str, head: str) -> list[list[str]]:
    """Returns the cells of the rows of the table of a file that begins with `head`.

    Raises:
        ValueError: The file, relative to the root, has no such table.
    """
    lines = (ROOT / path).read_text().split("\n")
    first = next((i for i, line in enumerate(lines) if line.startswith(head)), None)
    if first is None:
        raise ValueError(f"{path} has no table that begins with {head!r}")
    rows = []
    for line in lines[first + 2 :]:
        if not line.startswith("|"):
            break
        rows.append([cell.strip() for cell in line.strip("|").split("|")])
    return rows
