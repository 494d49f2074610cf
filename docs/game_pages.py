"""Pages of the games: words of games.toml, facts of the catalog and of game_facts.json."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

from markdown import table

import procgen_client

_HERE = Path(__file__).parent
WORDS: dict[str, Any] = tomllib.loads((_HERE / "games.toml").read_text())
FACTS: dict[str, Any] = json.loads((_HERE / "game_facts.json").read_text())
NOTHING = "does nothing"


def pages() -> dict[str, str]:
    """Returns a page for each game, the list of games and the gallery, by path on the site."""
    games = procgen_client.catalog()["games"]
    result = {f"games/{game['name']}.md": _page(game) for game in games}
    result["games/index.md"] = _index(games)
    result["games/gallery.md"] = _gallery(games)
    return result


def action_words(game: Any) -> list[str]:
    """Returns what each of the 15 actions does."""
    words = [NOTHING] * procgen_client.ACTION_COUNT
    for action, text in game["special_actions"].items():
        words[int(action)] = text[0].lower() + text[1:].rstrip(".")
    for actions, text in WORDS[game["name"]]["moves"].items():
        for action in actions.split(","):
            words[int(action)] = text
    return words


def _page(game: Any) -> str:
    name = game["name"]
    words, facts = WORDS[name], FACTS[name]
    notes = [*words["notes"], *_first_steps(facts)]
    blocks = [
        f"# {name}",
        game["description"],
        f"![Levels of {name}, as people and as agents see them](sheets/{name}.png)",
        "## Rules",
        "\n".join(f"- {rule}" for rule in words["rules"]),
        "## Rewards and returns",
        table(["event", "reward"], words["rewards"]),
        f"Return of an episode: {words['returns']}.",
        _modes(game, facts),
        f"Random agent: lowest and highest return of {_episodes(facts)} episodes, and in "
        "parentheses the mean of 2,000. Normalised scores map the range of the paper to 0 and 1.",
        "## Actions",
        _actions(game, facts["actions"]),
        f"The last column is measured: from {facts['actions']['states']:,} states of random play "
        "in easy mode, how often the next four observations and rewards differ from those after "
        "doing nothing.",
        "## Known oddities",
        "\n".join(f"- {note}" for note in notes),
    ]
    if "overlap" in facts:
        blocks += ["## Overlap of training and test levels", _overlap(facts["overlap"])]
    return "\n\n".join(blocks) + "\n"


def _modes(game: Any, facts: Any) -> str:
    rows = []
    for mode, values in game["modes"].items():
        paper = values["return_range"]
        random = facts["random_returns"].get(mode)
        note = f" (level {values['level_seed']} only)" if "level_seed" in values else ""
        rows.append([
            mode + note,
            f"{values['time_limit_steps']:,}",
            f"{paper[0]:g} to {paper[1]:g}" if paper else "–",
            f"{random['min']:g} to {random['max']:g} ({random['mean']:g})" if random else "–",
        ])  # fmt: skip
    return table(["mode", "time limit (steps)", "range of the paper", "random agent"], rows)


def _episodes(facts: Any) -> str:
    return f"{facts['random_returns']['easy']['episodes']:,}"


def _actions(game: Any, facts: Any) -> str:
    rows = []
    for action, words in enumerate(action_words(game)):
        key = procgen_client.catalog()["actions"][action]["name"]
        rows.append([str(action), key, words, f"{facts['differs_percent'][action]:g} %"])
    return table(["action", "keys", "effect", "differs from doing nothing"], rows)


def _first_steps(facts: Any) -> list[str]:
    """Returns sentences on levels that are decided in the first step."""
    sentences = []
    for outcome, words in (("won", "are won"), ("lost", "are lost, whatever the action,")):
        counts = {mode: len(of[outcome]) for mode, of in facts["first_step"].items()}
        if any(counts.values()):
            levels = next(iter(facts["first_step"].values()))["levels"]
            listed = ", ".join(f"{count} in {mode} mode" for mode, count in counts.items())
            first = next(of[outcome] for of in facts["first_step"].values() if of[outcome])
            sentences.append(
                f"Of levels 0 to {levels - 1:,}, these {words} in the first step: {listed}; the "
                f"first ones are {', '.join(map(str, first[:5]))}."
            )
    return sentences


def _overlap(facts: Any) -> str:
    rows = [
        [mode, f"{of['equal_of_1500_percent']:g} %", str(of["training_levels"]),
         f"{of['unseen_percent']:g} %"]
        for mode, of in facts.items()
    ]  # fmt: skip
    head = ["mode", "levels 1,500 to 2,999 equal to one of 0 to 1,499", "training levels (paper)",
            "unseen levels equal to a training level"]  # fmt: skip
    text = (
        "Two levels are equal if their first pictures are, without backgrounds and themes. Unseen: "
        "5,000 levels from seed 1,000,000 on."
    )
    if any(of["unseen_percent"] for of in facts.values()):
        text += " A test score on equal levels measures memory, not generalisation."
    return f"{table(head, rows)}\n\n{text}"


def _index(games: Any) -> str:
    names = "\n".join(game["name"] for game in games)
    rows = []
    for game in games:
        steps = FACTS[game["name"]]["first_step"]["easy"]
        overlap = FACTS[game["name"]].get("overlap", {}).get("easy")
        rows.append([
            f"[{game['name']}]({game['name']}.md)",
            game["description"],
            ", ".join(game["modes"]),
            str(len(steps["won"])),
            str(len(steps["lost"])),
            f"{overlap['unseen_percent']:g} %" if overlap else "–",
        ])  # fmt: skip
    head = ["game", "", "modes", "won at once", "lost at once", "overlap"]
    return "\n\n".join([
        "# Games",
        "Each page has pictures, rules, rewards, what the 15 actions do, and known oddities. All "
        "behaviour is that of Procgen 0.10.7, oddities included.",
        table(head, rows),
        "Easy mode, of 2,000 levels. Won at once: a first step without a move completes the level. "
        "Lost at once: every first action ends the episode without completing it. Overlap: the "
        "share of unseen levels that equal one of 200 training levels; – where a first picture "
        "does not show the level. `docs/measure_games.py` measures all figures of these pages.",
        f"```{{toctree}}\n:hidden:\n\n{names}\n```",
    ]) + "\n"  # fmt: skip


def _gallery(games: Any) -> str:
    blocks = [
        "# Gallery",
        "Drawn by `procgen-gallery` with the built-in art when this site was built.",
        "![One row per game, one level per picture](sheets/games.png)",
        "## Sprites",
    ]
    for name in [*(game["name"] for game in games), "shared"]:
        blocks += [f"### {name}", f"![Sprites of {name}](sheets/{name}_sprites.png)"]
    return "\n\n".join(blocks) + "\n"
