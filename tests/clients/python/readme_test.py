"""The examples of clients/python/README.md run; only the server's address is replaced."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from procgen_client import ServerProcess

_README = Path(__file__).resolve().parents[3] / "clients/python/README.md"
_EXAMPLES = re.findall(r"^```python\n(.*?)^```$", _README.read_text(), re.DOTALL | re.MULTILINE)


def test_readme_has_examples() -> None:
    assert len(_EXAMPLES) >= 5


@pytest.mark.parametrize("example", _EXAMPLES, ids=range(len(_EXAMPLES)))
def test_example_runs(server: ServerProcess, example: str) -> None:
    # Examples without a server address start a server.
    source = example.replace('"localhost:50051"', repr(server.address))
    assert "localhost" not in source
    exec(compile(source, str(_README), "exec"), {"__name__": "example"})
