"""Runs notebooks, and writes pages with their results.

A notebook runs in this process, without Jupyter: the value of a cell's last expression is shown, as
an image if it has `_repr_png_`. Notebooks are committed without results.
"""

from __future__ import annotations

import ast
import contextlib
import io
import json
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any


def run(notebook: Path) -> Iterator[tuple[str, str, Any]]:
    """Yields (source, output, value) of each code cell and (source, "", None) of each text.

    It runs in an empty folder. The exception of a cell is passed on.
    """
    names: dict[str, Any] = {"__name__": "__main__"}
    here = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            for cell in json.loads(notebook.read_text())["cells"]:
                source = "".join(cell["source"])
                if cell["cell_type"] == "code":
                    yield source, *_executed(source, names)
                else:
                    yield source, "", None
        finally:
            os.chdir(here)


def _executed(source: str, names: dict[str, Any]) -> tuple[str, Any]:
    module = ast.parse(source)
    last = module.body.pop() if module.body and isinstance(module.body[-1], ast.Expr) else None
    output = io.StringIO()
    value = None
    with contextlib.redirect_stdout(output):
        exec(compile(module, "cell", "exec"), names)
        if last is not None:
            value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)
    return output.getvalue(), value


def write_page(notebook: Path, folder: Path) -> Path:
    """Writes the notebook as a page with its images, unless the page is newer; returns its path."""
    page = folder / f"{notebook.stem}.md"
    if page.exists() and page.stat().st_mtime > notebook.stat().st_mtime:
        return page
    folder.mkdir(parents=True, exist_ok=True)
    blocks = []
    cells = json.loads(notebook.read_text())["cells"]
    for i, (cell, (source, output, value)) in enumerate(zip(cells, run(notebook), strict=True)):
        blocks.append(f"```python\n{source}\n```" if cell["cell_type"] == "code" else source)
        if output:
            blocks.append(f"```text\n{output.rstrip()}\n```")
        if hasattr(value, "_repr_png_"):
            image = f"{notebook.stem}_{i}.png"
            (folder / image).write_bytes(value._repr_png_())
            blocks.append(f"![Result of the cell above]({image})")
        elif value is not None:
            blocks.append(f"```text\n{value!r}\n```")
    page.write_text("\n\n".join(blocks) + "\n")
    return page
