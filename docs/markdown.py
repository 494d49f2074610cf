"""Markdown from the comments of source files."""

from __future__ import annotations

import re

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
