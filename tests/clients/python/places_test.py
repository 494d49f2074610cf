"""Pools in this process and on a server return equal values, in all games and modes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from conftest import assert_same

from procgen_client import Client, LevelSampler, Pool, Reset, ServerProcess, catalog
from procgen_client.options import GAMES

_N = 4
_STEPS = 60
_MODES = [(game["name"], mode) for game in catalog()["games"] for mode in game["modes"]]


@pytest.fixture(scope="module")
def one_client(server: ServerProcess) -> Iterator[Client]:
    """A connection for all tests."""
    with Client(server.address) as connected:
        yield connected


def assert_places_equal(
    client: Client, games: str | list[str], **options: Any  # noqa: ANN401
) -> int:
    """Plays in both places, with all kinds of requests; returns the number of ended episodes."""
    rng = np.random.default_rng(len(str(games)))
    ended_count = 0
    with (
        Pool(games, _N, rand_seed=5, **options) as pool,
        client.create_pool(games, _N, rand_seed=5, **options) as served,
    ):
        assert pool.observation_shape == served.observation_shape
        assert_same(pool.observe(), served.observe())
        for t in range(_STEPS):
            arguments: dict[str, Any] = {
                "actions": rng.integers(-1, 15, _N),
                "final_observations": pool.autoreset_mode == "same_step",
                "repeat_count": 1 if t % 5 else 4,
                "next_levels": {t % _N: int(rng.integers(-1000, 1000))} if t % 9 == 2 else None,
                "resets": [Reset(t % _N, rand_seed=t), (t + 1) % _N] if t % 11 == 3 else (),
            }
            batch = pool.step(**arguments)
            assert_same(batch, served.step(**arguments))
            ended_count += int(batch.ended.sum())
        assert pool.save_states() == served.save_states()
        for whole_level in (False, True):
            np.testing.assert_array_equal(
                pool.render([1], size_px=96, whole_level=whole_level),
                served.render([1], size_px=96, whole_level=whole_level),
            )
    return ended_count


def test_catalog_has_all_games_and_their_modes() -> None:
    assert {game for game, _ in _MODES} == set(GAMES)
    assert {mode for _, mode in _MODES} == {"easy", "hard", "extreme", "memory", "exploration"}


@pytest.mark.parametrize(
    ("game", "mode", "autoreset_mode"),
    # The autoreset modes alternate: they are the same for all games.
    [(*each, ("same_step", "next_step")[i % 2]) for i, each in enumerate(_MODES)],
)
def test_each_mode_of_each_game_is_equal(
    one_client: Client, game: str, mode: str, autoreset_mode: str
) -> None:
    options = {"distribution_mode": mode, "autoreset_mode": autoreset_mode}
    assert assert_places_equal(one_client, game, **options) > 3


@pytest.mark.parametrize(
    "options",
    [
        {"num_levels": 3, "start_level": 50, "use_sequential_levels": True},
        {"center_agent": False, "use_backgrounds": False, "paint_vel_info": True},
        {"use_generated_assets": True, "restrict_themes": True},
        {"use_monochrome_assets": True, "screen_size": 100, "layout": "chw"},
        {"grayscale_obs": True, "frame_stack": 4, "screen_size": 84},
        {"level_sampler": LevelSampler(range(20), range(20), rand_seed=7)},
        {"first_env": 4, "total_env_count": 12},
    ],
    ids=lambda options: "-".join(options),
)
def test_options_have_equal_effects(one_client: Client, options: dict[str, Any]) -> None:
    games = ["coinrun", "jumper"]
    assert assert_places_equal(one_client, games, distribution_mode="easy", **options) > 3


@pytest.mark.parametrize(
    ("game", "variant"),
    [(game["name"], name) for game in catalog()["games"] for name in game["variants"]],
)
def test_variants_are_equal(one_client: Client, game: str, variant: str) -> None:
    options = {"distribution_mode": "easy", "variant": variant}
    assert assert_places_equal(one_client, game, **options) > 3


def test_defaults_are_equal(one_client: Client) -> None:
    assert assert_places_equal(one_client, "coinrun") > 3
