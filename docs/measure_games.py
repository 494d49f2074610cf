#!/usr/bin/env python3
"""Measures the facts of the game pages and writes them to game_facts.json, beside this file.

Usage: PYTHONPATH=clients/python docs/measure_games.py [GAME...]; without games, all. About twenty
minutes of one core; results are equal on every machine.
Per game:

- actions: which of the 15 actions lead to equal observations and rewards, from states of random
  play, and how often each differs from doing nothing.
- first_step: of 2,000 levels, those that a first step without a move completes, and those that
  every first action loses. Each level is the first of its pool.
- overlap: of OVERLAP_GAMES, the share of levels that equal another level, see `overlap`.
- random_returns: lowest, highest and mean return of 2,000 episodes of a random agent.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from procgen_client import ACTION_COUNT, Pool, Reset, catalog

FACTS = Path(__file__).with_name("game_facts.json")
NOTHING = 4  # The action without a key.

FIRST_STEP_LEVELS = 2_000
OVERLAP_LEVELS = 1_500
# Games whose first view can show the whole level: nothing is drawn by chance later.
OVERLAP_GAMES = ("caveflyer", "climber", "coinrun", "fruitbot", "heist", "jumper", "maze", "miner",
                 "ninja")
PAPER_LEVELS = {"easy": 200, "hard": 500}  # Training levels of the benchmark's paper.
UNSEEN_LEVELS = range(1_000_000, 1_005_000)


def main() -> None:
    """Measures games and updates the file after each."""
    parser = argparse.ArgumentParser()
    parser.add_argument("games", nargs="*")
    arguments = parser.parse_args()
    known = {game["name"]: game for game in catalog()["games"]}
    facts: dict[str, Any] = json.loads(FACTS.read_text()) if FACTS.exists() else {}
    for name in arguments.games or known:
        modes = [mode for mode in known[name]["modes"] if mode != "exploration"]
        facts[name] = {
            "actions": actions(name),
            "first_step": {mode: first_step(name, mode) for mode in modes},
            "random_returns": {mode: random_returns(name, mode) for mode in PAPER_LEVELS},
        }
        if name in OVERLAP_GAMES:
            facts[name]["overlap"] = {mode: overlap(name, mode) for mode in PAPER_LEVELS}
        ordered = {game: facts[game] for game in known if game in facts}
        FACTS.write_text(_text(ordered))
        print(name, flush=True)


def _text(facts: dict[str, Any]) -> str:
    """Returns JSON with each list of numbers on one line."""
    text = json.dumps(facts, indent=1) + "\n"
    return re.sub(r"\[([-\d.,\s]+)\]", lambda match: f"[{' '.join(match[1].split())}]", text)


def actions(name: str) -> dict[str, Any]:
    """Compares all actions from the same states: the observations of four steps, the last three
    without a key. Returns the groups of actions that were always equal, the one that does nothing
    first, and in percent of the states how often the action differs from doing nothing."""
    states, rounds = 32, 60
    rng = np.random.default_rng(0)
    differs = np.zeros((ACTION_COUNT, ACTION_COUNT), int)
    with (
        Pool(name, states, distribution_mode="easy", rand_seed=0) as player,
        Pool(name, states * ACTION_COUNT, distribution_mode="easy", rand_seed=0) as probe,
    ):
        tried = np.tile(np.arange(ACTION_COUNT), states)
        for _ in range(rounds):
            for _ in range(rng.integers(1, 12)):
                held = rng.integers(0, ACTION_COUNT, states)
                player.step(held, observe=False, repeat_count=int(rng.integers(1, 5)))
            saved = player.save_states()
            probe.restore_states({i: saved[i // ACTION_COUNT] for i in range(probe.env_count)})
            seen = [hashlib.sha1() for _ in tried]
            for step in range(4):
                batch = probe.step(tried if step == 0 else np.full_like(tried, NOTHING))
                for i, digest in enumerate(seen):
                    digest.update(batch.observations[i])
                    digest.update(batch.rewards[i])
            rows = np.array([digest.digest()[:8] for digest in seen], "S8")
            rows = rows.reshape(states, ACTION_COUNT)
            differs += (rows[:, :, None] != rows[:, None, :]).sum(0)
    groups: list[list[int]] = [[NOTHING]]
    for action in range(ACTION_COUNT):
        if action == NOTHING:
            continue
        group = next((group for group in groups if differs[action, group[0]] == 0), None)
        if group is None:
            groups.append([action])
        else:
            group.append(action)
    shares = (100 * differs[NOTHING] / (states * rounds)).round(1)
    return {"states": states * rounds, "groups": groups, "differs_percent": shares.tolist()}


def first_step(name: str, mode: str) -> dict[str, Any]:
    """Takes every first action in levels 0 to FIRST_STEP_LEVELS - 1."""
    won, lost = [], []
    for level in range(FIRST_STEP_LEVELS):
        options = {"distribution_mode": mode, "num_levels": 1, "start_level": level}
        with Pool(name, ACTION_COUNT, rand_seed=0, num_threads=0, **options) as pool:
            batch = pool.step(np.arange(ACTION_COUNT), observe=False)
        if batch.prev_level_complete[NOTHING]:
            won.append(level)
        if (batch.terminated & ~batch.prev_level_complete).all():
            lost.append(level)
    return {"levels": FIRST_STEP_LEVELS, "won": won, "lost": lost}


def overlap(name: str, mode: str) -> dict[str, Any]:
    """Compares first observations of whole levels, without backgrounds and themes: the share in
    percent of levels 1,500 to 2,999 that equal one of levels 0 to 1,499, and of 5,000 unseen
    levels that equal one of the paper's training levels."""
    options = {"center_agent": False, "use_backgrounds": False, "restrict_themes": True}
    with Pool(name, 50, distribution_mode=mode, screen_size=192, **options) as pool:
        first = list(_digests(pool, range(2 * OVERLAP_LEVELS)))
        unseen = list(_digests(pool, UNSEEN_LEVELS))
    early, late = set(first[:OVERLAP_LEVELS]), first[OVERLAP_LEVELS:]
    training = set(first[: PAPER_LEVELS[mode]])
    return {
        "equal_of_1500_percent": round(100 * sum(each in early for each in late) / len(late), 2),
        "training_levels": PAPER_LEVELS[mode],
        "unseen_percent": round(100 * sum(each in training for each in unseen) / len(unseen), 2),
    }


def _digests(pool: Pool, levels: Iterable[int]) -> Iterable[bytes]:
    """Yields a hash of the first observation of each level; their number is a multiple of N."""
    rest = list(levels)
    while rest:
        some, rest = rest[: pool.env_count], rest[pool.env_count :]
        resets = [Reset(i, level_seed=level) for i, level in enumerate(some)]
        for observation in pool.reset(resets).observations:
            yield hashlib.sha1(observation).digest()


def random_returns(name: str, mode: str) -> dict[str, Any]:
    """Plays 2,000 episodes with random actions: the first 20 of each of 100 environments.

    The first 2,000 episodes to end would over-represent short ones.
    """
    rng = np.random.default_rng(0)
    returns: list[float] = []
    counts = np.zeros(100, int)
    with Pool(name, 100, distribution_mode=mode, rand_seed=0) as pool:
        while (counts < 20).any():
            batch = pool.step(rng.integers(0, ACTION_COUNT, 100), observe=False)
            ended = batch.ended & (counts < 20)
            returns += batch.episode_returns[ended].tolist()
            counts += ended
    return {
        "episodes": len(returns),
        "min": round(min(returns), 2),
        "max": round(max(returns), 2),
        "mean": round(sum(returns) / len(returns), 2),
    }


if __name__ == "__main__":
    main()
