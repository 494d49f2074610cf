"""Errors from a server's texts."""

from __future__ import annotations

import pytest

from procgen_client import Client, errors


def test_control_characters_of_a_servers_text_are_escaped() -> None:
    error = errors.of_code(5, "no \x1b]0;title\x07\x1b[2J\r\n\x7f\x9b ä € \\")
    assert error.message == r"no \x1b]0;title\x07\x1b[2J\x0d\x0a\x7f\x9b ä € " + "\\"
    assert isinstance(error, errors.NotFoundError)


def test_text_that_a_server_repeats_reaches_no_terminal_raw(client: Client) -> None:
    with pytest.raises(errors.ProcgenError) as caught:
        client.create_pool("maze\x1b[2J", 1)
    assert "maze" in str(caught.value)
    assert "\x1b" not in str(caught.value)
