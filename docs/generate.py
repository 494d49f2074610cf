#!/usr/bin/env python3
"""Writes the sources of the documentation site into a folder; docs/build.sh runs this and Sphinx.

Usage: PYTHONPATH=clients/python docs/generate.py OUT_FOLDER SHEETS_FOLDER

Every Markdown file of the repository becomes a page at its own path, README.md as index.md. Files
that pages link to are copied. Pages of games, of the gallery, of the APIs and the notebooks are
generated. SHEETS_FOLDER has the images of procgen-gallery.
"""

from __future__ import annotations

import posixpath
import re
import shutil
import subprocess
import sys
from pathlib import Path

import charts
import contract_pages
import game_pages
import header_pages
import notebooks
import python_pages

ROOT = Path(__file__).resolve().parents[1]
CONTENTS = "docs/contents.md"
_LINK = re.compile(r"(\]\()([^)#\s]+)(#[^)\s]*)?(\))")


def main(out: Path, sheets: Path) -> None:
    """Writes all pages. Pages that are unchanged keep their time, so that Sphinx skips them."""
    tracked = set(_tracked())
    sources = sorted(path for path in tracked if path.endswith(".md") and path != CONTENTS)
    pages = {
        page_name(path): _with_links_of_site(path, tracked, out) + _contents_of(path, sources)
        for path in sources
    }
    pages |= game_pages.pages() | contract_pages.pages()
    pages |= header_pages.pages() | python_pages.pages()
    for name, text in pages.items():
        _write(out / name, text)
    for name, text in charts.charts().items():
        _write(out / "docs/charts" / name, text)
    for sheet in sheets.glob("*.png"):
        _copy(sheet, out / "games/sheets" / sheet.name)
    for notebook in sorted(Path(__file__).parent.glob("notebooks/*.ipynb")):
        page = notebooks.write_page(notebook, out / "docs/notebooks")
        pages[str(page.relative_to(out))] = ""
    for old in [*out.rglob("*.md"), *out.rglob("*.rst")]:
        if str(old.relative_to(out)) not in pages:
            old.unlink()


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text() != text:
        path.write_text(text)


def page_name(path: str) -> str:
    """Returns where the page of a Markdown file of the repository is on the site."""
    return re.sub(r"(^|/)README\.md$", r"\1index.md", path)


def _tracked() -> list[str]:
    listed = subprocess.check_output(["git", "ls-files", "-z"], cwd=ROOT, text=True)
    return [path for path in listed.split("\0") if path and (ROOT / path).exists()]


def _with_links_of_site(path: str, tracked: set[str], out: Path) -> str:
    """Returns a Markdown file with links to pages, and copies the other files that it links to."""
    folder = posixpath.dirname(path)

    def on_site(match: re.Match[str]) -> str:
        before, target, anchor, after = match.groups()
        if "://" in target or target.startswith("mailto:"):
            return match[0]
        linked = posixpath.normpath(posixpath.join(folder, target))
        if f"{linked}/README.md" in tracked:
            target = target.rstrip("/") + "/README.md"
        elif linked in tracked and not linked.endswith(".md"):
            _copy(ROOT / linked, out / linked)
        return before + page_name(target) + (anchor or "") + after

    return _LINK.sub(on_site, (ROOT / path).read_text())


def _contents_of(path: str, pages: list[str]) -> str:
    """Returns the contents of a README.md: the pages of its folder, and the READMEs below it that
    have no other README.md between. Those of the root are in contents.md."""
    contents = (ROOT / CONTENTS).read_text()
    if path == "README.md":
        return "\n" + contents
    if posixpath.basename(path) != "README.md":
        return ""
    below = []
    for page in pages:
        folder = posixpath.dirname(page)
        if posixpath.basename(page) == "README.md":
            folder = posixpath.dirname(folder)
        while folder and f"{folder}/README.md" not in pages:
            folder = posixpath.dirname(folder)
        name = page_name(page).removesuffix(".md")
        if folder == posixpath.dirname(path) and page != path and name not in contents.split():
            below.append("/" + name)
    return "\n```{toctree}\n:hidden:\n\n" + "\n".join(below) + "\n```\n" if below else ""


def _copy(source: Path, target: Path) -> None:
    if not target.exists() or target.stat().st_mtime < source.stat().st_mtime:
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, target)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
