"""Errors: their classes, codes and texts."""

from __future__ import annotations

import pickle

import pytest
from conftest import MakePool

from procgen_client import errors


def test_errors_have_code_and_message_and_can_be_pickled() -> None:
    error = errors.NotFoundError("no such pool")
    copy = pickle.loads(pickle.dumps(error))
    assert (type(copy), copy.code.name, copy.message) == (type(error), "NOT_FOUND", "no such pool")
    assert str(copy) == "NOT_FOUND: no such pool"
    assert issubclass(errors.InvalidArgumentError, ValueError)


@pytest.mark.parametrize("number", [1, 3, 4, 5, 6, 7, 8, 9, 10, 12, 13, 14, 15, 16])
def test_each_code_has_a_class(number: int) -> None:
    error = errors.of_code(number, "text")
    assert type(error) is not errors.ProcgenError
    assert error.code == number
    assert type(errors.of_code(99, "text")) is errors.ProcgenError


def test_control_characters_of_a_servers_text_are_escaped() -> None:
    error = errors.of_code(5, "no \x1b]0;title\x07\x1b[2J\r\n\x7f\x9b ä € \\")
    assert error.message == r"no \x1b]0;title\x07\x1b[2J\x0d\x0a\x7f\x9b ä € " + "\\"
    assert isinstance(error, errors.NotFoundError)


def test_text_that_is_repeated_reaches_no_terminal_raw(make_pool: MakePool) -> None:
    with pytest.raises(errors.ProcgenError) as caught:
        make_pool("maze\x1b[2J", 1)
    assert "maze" in str(caught.value)
    assert "\x1b" not in str(caught.value)
