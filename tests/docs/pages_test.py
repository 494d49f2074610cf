"""Pages of the APIs have every public name, with its comment."""

from __future__ import annotations

import re
from pathlib import Path

import charts
import contract_pages
import generate
import header_pages
import markdown
import pytest
import python_pages

_ROOT = Path(__file__).resolve().parents[2]


def test_every_function_of_the_headers_has_its_comment_and_declaration() -> None:
    page = header_pages.pages()["reference/c.md"]
    for header in ("procgen.h", "procgen_remote.h"):
        text = (_ROOT / "clients/c" / header).read_text()
        names = re.findall(r"^PROCGEN_API [^(]*?(\w+)\(", text, re.MULTILINE)
        assert len(names) > 10
        for name in names:
            assert f"### {name}\n" in page
    assert (
        "### procgen_pool_destroy\n\nFrees a pool. Unanswered requests end first. Null is ignored."
        "\n\n```c\nPROCGEN_API void procgen_pool_destroy(ProcgenPool* pool);\n" in page
    )


def test_every_method_and_message_of_the_protos_has_its_comment() -> None:
    pages = contract_pages.pages()
    for proto in sorted((_ROOT / "proto/procgen/v1").glob("*.proto")):
        page = pages[f"reference/contract/{proto.stem}.md"]
        for name in re.findall(r"^\s*(?:rpc|message|enum) (\w+)", proto.read_text(), re.MULTILINE):
            assert re.search(rf"^##+ (\w+\.)?{name}$", page, re.MULTILINE), name
    method = "### GetPool\n\n```text\nrpc GetPool(GetPoolRequest) returns (Pool)\n```\n\nReturns"
    assert method in pages["reference/contract/pool_service.md"]
    field = "| `env_count` | int32 | Number of environments, N."
    assert field in pages["reference/contract/pools.md"]


def test_a_public_name_in_no_section_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    assert ".. autoclass:: procgen_client.Pool\n" in python_pages.pages()["reference/python.rst"]
    monkeypatch.delitem(python_pages._SECTIONS, "Servers")
    with pytest.raises(ValueError, match="ServerProcess"):
        python_pages.pages()


def test_charts_have_the_numbers_of_the_tables() -> None:
    drawn = charts.charts()
    row = next(
        line
        for line in (_ROOT / "README.md").read_text().split("\n")
        if line.startswith("| bigfish, easy | 1 |")
    )
    for number in re.findall(r"\d+,\d{3}", row)[1:]:
        assert f">{number}</text>" in drawn["throughput.svg"]
    with pytest.raises(ValueError, match="no table"):
        markdown.rows_of_table("README.md", "| no such |")


def test_every_page_of_the_repository_begins_with_its_title() -> None:
    tracked = generate._tracked()
    pages = [page for page in tracked if page.endswith(".md") and page != generate.CONTENTS]
    assert len(pages) > 10
    assert [page for page in pages if not (_ROOT / page).read_text().startswith("# ")] == []


def test_comments_keep_code_and_layout() -> None:
    comment = ["Of [n, F] and `a_b`,", "a_b.", "", "Errors:", "  NOT_FOUND  none"]
    assert markdown.from_comment(comment) == (
        "Of \\[n, F\\] and `a_b`, a\\_b.\n\n```text\nErrors:\n  NOT_FOUND  none\n```"
    )
