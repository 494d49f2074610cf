"""The documentation site builds without a warning, and its links work."""

from __future__ import annotations

import html.parser
import json
import os
import re
import subprocess
from pathlib import Path
from urllib.parse import unquote, urlsplit

import notebooks
import pytest

from procgen_client import ENV_NAMES

pytest.importorskip("sphinx")
pytest.importorskip("myst_parser")
pytest.importorskip("furo")

_ROOT = Path(__file__).resolve().parents[2]
_BUILD = Path(os.environ["PROCGEN_BUILD_DIR"])


@pytest.fixture(scope="session")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    command = [_ROOT / "docs/build.sh", "--build", _BUILD, "--output", folder]
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr[-4000:]
    return folder


class _Links(html.parser.HTMLParser):
    """The links and the anchors of a page."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.feed(page.read_text())

    def handle_starttag(self, _tag: str, attributes: list[tuple[str, str | None]]) -> None:
        for name, value in attributes:
            if name in ("href", "src") and value:
                self.links.append(value)
            if name == "id" and value:
                self.anchors.add(value)


def broken_links(site: Path) -> list[str]:
    """Returns "page: link" for each link to a missing file or anchor of the site."""
    pages = {page: _Links(page) for page in site.rglob("*.html")}
    found = []
    for page, content in pages.items():
        for link in content.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
            anchors = pages[target].anchors if target in pages else set()
            if not target.is_file() or (target in pages and parts.fragment not in anchors | {""}):
                found.append(f"{page.relative_to(site)}: {link}")
    return found


def test_the_check_of_links_finds_missing_files_and_anchors(tmp_path: Path) -> None:
    (tmp_path / "a.html").write_text('<a href="b.html#here">x</a><a href="http://x.org/y">x</a>')
    (tmp_path / "b.html").write_text('<p id="here"></p><a href="a.html#no"></a><img src="c.png">')
    assert broken_links(tmp_path) == ["b.html: a.html#no", "b.html: c.png"]


def test_every_link_resolves(site: Path) -> None:
    assert broken_links(site) == []


@pytest.mark.parametrize("game", ENV_NAMES)
def test_every_game_has_its_page_with_its_picture(site: Path, game: str) -> None:
    page = (site / f"games/{game}.html").read_text()
    assert f"_images/{game}.png" in page
    assert (site / f"_images/{game}.png").stat().st_size > 50_000


def test_pages_of_guides_apis_and_notebooks_are_there(site: Path) -> None:
    assert "procgen_client.ProcgenVectorEnv" in (site / "reference/python.html").read_text()
    assert "procgen_pool_create" in (site / "reference/c.html").read_text()
    assert "RunPool" in (site / "reference/contract/pool_service.html").read_text()
    assert "With PPO" in (site / "clients/python/guides/one-machine.html").read_text()
    assert "train_and_look_" in (site / "docs/notebooks/train_and_look.html").read_text()


@pytest.mark.parametrize("notebook", sorted((_ROOT / "docs/notebooks").glob("*.ipynb")))
def test_every_notebook_runs(notebook: Path, tmp_path: Path) -> None:
    page = notebooks.write_page(notebook, tmp_path)
    cells = sum(cell["cell_type"] == "code" for cell in json.loads(notebook.read_text())["cells"])
    assert page.read_text().count("```python\n") == cells
    assert list(tmp_path.glob("*.png"))


def test_the_search_finds_words_of_pages(site: Path) -> None:
    index = (site / "searchindex.js").read_text()
    assert '"games/jumper"' in index
    assert re.search(r'"?carrot"?: ?\[?\d', index)
