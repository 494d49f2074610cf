"""The words of the game pages agree with the measurements, and these with the engine."""

from __future__ import annotations

from typing import Any

import game_pages
import measure_games
import pytest

from procgen_client import catalog

_GAMES = {game["name"]: game for game in catalog()["games"]}


def test_every_game_has_words_and_facts() -> None:
    assert set(game_pages.WORDS) == set(game_pages.FACTS) == set(_GAMES)
    assert set(_GAMES) < {page.split("/")[1].removesuffix(".md") for page in game_pages.pages()}


@pytest.mark.parametrize("name", _GAMES)
def test_actions_do_nothing_in_words_if_nothing_was_measured(name: str) -> None:
    words = game_pages.action_words(_GAMES[name])
    never_differs = [share == 0 for share in game_pages.FACTS[name]["actions"]["differs_percent"]]
    assert [each == game_pages.NOTHING for each in words] == never_differs


@pytest.mark.parametrize("name", _GAMES)
def test_actions_of_one_entry_were_equal_and_others_not(name: str) -> None:
    groups = game_pages.FACTS[name]["actions"]["groups"]
    group_of = {action: i for i, group in enumerate(groups) for action in group}
    for actions in game_pages.WORDS[name]["moves"]:
        together = [int(action) for action in actions.split(",")]
        assert {tuple(groups[group_of[action]]) for action in together} == {tuple(together)}


@pytest.mark.parametrize("name", ["caveflyer", "jumper", "miner"])
def test_levels_decided_in_the_first_step_are_measured_again(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(measure_games, "FIRST_STEP_LEVELS", 300)
    facts: dict[str, Any] = game_pages.FACTS[name]["first_step"]["easy"]
    measured = measure_games.first_step(name, "easy")
    assert measured["won"] + measured["lost"]
    for outcome in ("won", "lost"):
        assert measured[outcome] == [level for level in facts[outcome] if level < 300]


def test_a_page_has_what_was_measured() -> None:
    page = game_pages.pages()["games/jumper.md"]
    assert "| 5 | UP | jumps, once more in the air" in page
    assert "lost, whatever the action, in the first step: 175 in easy mode" in page
