"""Fingerprints equal those computed here from the batches, as proto/README.md defines them."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np
import pytest
from conftest import MakePool

from procgen_client import Pool, Reset

_README = Path(__file__).resolve().parents[3] / "proto/README.md"
_MODES = {"easy": 0, "hard": 1, "extreme": 2, "memory": 10, "exploration": 1}


def fnv1a(data: bytes) -> int:
    value = 14695981039346656037
    for byte in data:
        value = (value ^ byte) * 1099511628211 % 2**64
    return value


def begin(
    game: str, distribution_mode: str, *, debug_mode: int = 0, flags: tuple[bool, ...] | None = None
) -> bytes:
    # center_agent, use_backgrounds, use_generated_assets, use_monochrome_assets, restrict_themes,
    # paint_vel_info, use_sequential_levels.
    flags = (True, True, False, False, False, False, False) if flags is None else flags
    numbers = struct.pack("<ii", _MODES[distribution_mode], debug_mode)
    return game.encode() + b"\0" + numbers + bytes(flags)


def level(level_seed: int) -> bytes:
    return b"L" + struct.pack("<i", level_seed)


def step(action: int, reward: float, *, complete: bool, terminated: bool, truncated: bool) -> bytes:
    ends = complete + 2 * terminated + 4 * truncated
    return b"S" + struct.pack("<ifB", action, reward, ends)


def test_readme_example_is_correct(make_pool: MakePool) -> None:
    readme = _README.read_text()
    written = "".join(re.search(r"gives the bytes\n\n((?:    [0-9a-f ]+\n)+)", readme)[1].split())
    fingerprint = int(re.search(r"and the fingerprint (\d+)\.", readme)[1])
    recorded = begin("maze", "easy") + level(7)
    pool = make_pool("maze", 1, distribution_mode="easy")
    pool.reset([Reset(0, level_seed=7)])
    for action in (4, 7, -1):
        batch = pool.step([action])
        recorded += step(
            action,
            batch.rewards[0],
            complete=batch.prev_level_complete[0],
            terminated=batch.terminated[0],
            truncated=batch.truncated[0],
        )
    assert recorded.hex() == written
    assert fnv1a(recorded) == fingerprint
    assert batch.fingerprints.tolist() == [fingerprint]


def check_episodes(pool: Pool, beginning: bytes, step_count: int) -> tuple[int, int]:
    """Compares the fingerprint of every ended episode with a computed one.

    Returns the number of ended episodes, and of levels that started within an episode.
    """
    batch = pool.observe()
    episodes = [beginning + level(seed) for seed in batch.level_seeds]
    ended_count = level_count = 0
    rng = np.random.default_rng(2)
    for _ in range(step_count):
        actions = rng.integers(0, 15, pool.env_count)
        batch = pool.step(actions, observe=False)
        expected = []
        for row, action in enumerate(actions):
            episodes[row] += step(
                action,
                batch.rewards[row],
                complete=batch.prev_level_complete[row],
                terminated=batch.terminated[row],
                truncated=batch.truncated[row],
            )
            if batch.ended[row]:
                expected.append(fnv1a(episodes[row]))
                episodes[row] = beginning
            continues = not batch.ended[row] and batch.prev_level_complete[row]
            if batch.ended[row] or continues:
                episodes[row] += level(batch.level_seeds[row])
            level_count += continues
        assert batch.fingerprints[batch.ended].tolist() == expected
        ended_count += len(expected)
    return ended_count, level_count


@pytest.mark.parametrize("game", ["bigfish", "starpilot", "fruitbot"])
def test_episode_fingerprints_follow_their_definition(make_pool: MakePool, game: str) -> None:
    pool = make_pool(game, 4, distribution_mode="hard", rand_seed=1)
    assert check_episodes(pool, begin(game, "hard"), 400)[0] > 4


def test_all_options_are_in_the_fingerprint(make_pool: MakePool) -> None:
    pool = make_pool(
        "maze",
        4,
        distribution_mode="easy",
        rand_seed=1,
        debug_mode=-3,
        center_agent=False,
        use_backgrounds=False,
        use_generated_assets=True,
        use_monochrome_assets=True,
        restrict_themes=True,
        paint_vel_info=True,
        use_sequential_levels=True,
    )
    flags = (False, False, True, True, True, True, True)
    beginning = begin("maze", "easy", debug_mode=-3, flags=flags)
    ended_count, level_count = check_episodes(pool, beginning, 1200)
    assert ended_count > 0
    assert level_count > 0


def test_exploration_mode_is_hashed_as_hard(make_pool: MakePool) -> None:
    pool = make_pool("coinrun", 2, distribution_mode="exploration")
    assert check_episodes(pool, begin("coinrun", "exploration"), 1001)[0] > 0
