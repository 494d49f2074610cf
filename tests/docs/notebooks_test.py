"""Notebooks run without Jupyter, and their pages show what cells return and print."""

from __future__ import annotations

import json
from pathlib import Path

import notebooks
import pytest
from PIL import Image


def _notebook(path: Path, *cells: tuple[str, str]) -> Path:
    listed = [{"cell_type": kind, "source": [source]} for kind, source in cells]
    path.write_text(json.dumps({"cells": listed}))
    return path


def test_cells_share_names_and_return_their_last_expression(tmp_path: Path) -> None:
    notebook = _notebook(
        tmp_path / "some.ipynb",
        ("markdown", "# Title"),
        ("code", "x = 6\nprint('six')"),
        ("code", "x * 7"),
    )
    assert list(notebooks.run(notebook)) == [
        ("# Title", "", None),
        ("x = 6\nprint('six')", "six\n", None),
        ("x * 7", "", 42),
    ]


def test_an_error_of_a_cell_is_passed_on_and_the_folder_is_restored(tmp_path: Path) -> None:
    here = Path.cwd()
    with pytest.raises(ZeroDivisionError):
        list(notebooks.run(_notebook(tmp_path / "some.ipynb", ("code", "1 / 0"))))
    assert Path.cwd() == here


def test_a_page_has_images_and_is_written_once(tmp_path: Path) -> None:
    source = "from PIL import Image\nprint('drawn')\nImage.new('RGB', (3, 2))"
    notebook = _notebook(tmp_path / "some.ipynb", ("code", source))
    notebooks.write_page(notebook, tmp_path / "out")
    page = tmp_path / "out/some.md"
    assert "```text\ndrawn\n```\n\n![Result of the cell above](some_0.png)" in page.read_text()
    assert Image.open(tmp_path / "out/some_0.png").size == (3, 2)
    page.write_text("kept")
    notebooks.write_page(notebook, tmp_path / "out")
    assert page.read_text() == "kept"


def test_committed_notebooks_have_no_results() -> None:
    found = list((Path(notebooks.__file__).parent / "notebooks").glob("*.ipynb"))
    assert found
    for notebook in found:
        cells = [c for c in json.loads(notebook.read_text())["cells"] if c["cell_type"] == "code"]
        assert cells
        assert not any(cell["outputs"] or cell["execution_count"] for cell in cells)
