"""The page of the C API, from the comments of its headers."""

from __future__ import annotations

import re
from pathlib import Path

from markdown import from_comment

HEADERS = Path(__file__).resolve().parents[1] / "clients/c"
_NAME = re.compile(
    r"typedef (?:enum|struct) (\w+)|#define (PROCGEN_[A-Z_]+) |\b(procgen_\w+)\(|\(\*(\w+)\)\("
)
_SKIPPED = re.compile(
    r"#(ifndef|ifdef|endif|include|define (CLIENTS_|PROCGEN_API))|extern \"C\"|\}  //|\}$"
)


def pages() -> dict[str, str]:
    """Returns the page by its path on the site."""
    blocks = [
        "# C API",
        "Two libraries behind plain C headers. [clients/c](../clients/c/index.md) says how to "
        "install and link them, and how other languages load them.",
    ]
    for header in ("procgen.h", "procgen_remote.h"):
        blocks += [f"## {header}", *_declarations((HEADERS / header).read_text())]
    return {"reference/c.md": "\n\n".join(blocks) + "\n"}


def _declarations(text: str) -> list[str]:
    """Returns comments as text, and declarations as headings and code, in the header's order."""
    blocks: list[str] = []
    comment: list[str] = []
    code: list[str] = []
    depth = 0

    def flush() -> None:
        if comment and not code:
            blocks.append(from_comment(comment))
        elif code:
            names = [next(filter(None, found)) for found in _NAME.findall("\n".join(code))]
            if names:
                blocks.append(f"### {names[0]}")
            blocks.append(from_comment(comment))
            blocks.append("```c\n" + "\n".join(code) + "\n```")
        comment.clear()
        code.clear()

    for line in text.split("\n"):
        ends = not code or (depth == 0 and code[-1].rstrip().endswith((";", "1", "5")))
        if depth == 0 and (not line.strip() or _SKIPPED.match(line)):
            flush()
        elif depth == 0 and line.startswith("//"):
            if code:
                flush()
            comment.append(line.removeprefix("//").removeprefix(" "))
        else:
            if code and ends and depth == 0:
                flush()
            code.append(line)
            depth += line.count("{") - line.count("}")
    flush()
    return [block for block in blocks if block]
