"""Variants: upstream's levels with one change."""

from __future__ import annotations

import numpy as np
import pytest

from procgen_client import Client, Pool, ProcgenVectorEnv, catalog, decode_state, errors

_OPTIONS = {"distribution_mode": "easy", "rand_seed": 5}
_VARIANTS = [(game["name"], name) for game in catalog()["games"] for name in game["variants"]]


@pytest.mark.parametrize(("game", "variant"), [each for each in _VARIANTS if "=" not in each[1]])
def test_variant_changes_objects_of_the_same_levels(game: str, variant: str) -> None:
    with Pool(game, 16, **_OPTIONS) as exact, Pool(game, 16, variant=variant, **_OPTIONS) as varied:
        for _ in range(3):
            before, after = exact.objects(), varied.objects()
            assert np.array_equal(exact.observe().level_seeds, varied.observe().level_seeds)
            assert np.array_equal(before.values[:, 0], after.values[:, 0])
            assert not np.array_equal(before.values, after.values)
            ended, other = exact.step([-1] * 16), varied.step([-1] * 16)
            assert not np.any(ended.fingerprints == other.fingerprints)


def test_coin_and_cheese_move_and_a_decoy_is_added() -> None:
    for game, variant, goal in (
        ("coinrun", "coin_random", "coin"),
        ("maze", "cheese_corner", "cheese"),
        ("maze", "two_objects", "cheese"),
    ):
        with Pool(game, 8, **_OPTIONS) as exact, Pool(game, 8, variant=variant, **_OPTIONS) as pool:
            before, after = exact.objects(), pool.objects()
            moved = before.positions_of(goal) != after.positions_of(goal)
            assert moved.any() == (variant != "two_objects")
            pixels = exact.observe().observations != pool.observe().observations
            assert pixels.any()
    assert not np.isnan(after.positions_of("decoy")).any()


@pytest.mark.parametrize(("game", "variant"), [each for each in _VARIANTS if "=" in each[1]])
def test_a_value_changes_steps_and_not_levels(game: str, variant: str) -> None:
    name, value = variant.split("=")
    other = f"{name}={float(value) * 2}"
    with Pool(game, 16, **_OPTIONS) as exact, Pool(game, 16, variant=other, **_OPTIONS) as varied:
        first, same = exact.observe(), varied.observe()
        assert np.array_equal(first.observations, same.observations)
        rng = np.random.default_rng(0)
        for actions in rng.integers(0, 9, (40, 16)):
            exact.step(actions, observe=False)
            varied.step(actions, observe=False)
        assert not np.array_equal(exact.objects().values, varied.objects().values)
        states = varied.save_states()
        exact.restore_states(states)
        actions = rng.integers(0, 9, 16)
        after, restored = varied.step(actions), exact.step(actions)
        assert np.array_equal(after.observations, restored.observations)
        assert decode_state(states[0])["options"]["variant_value"] == pytest.approx(
            float(value) * 2
        )


def test_unknown_variants_are_rejected() -> None:
    with pytest.raises(
        errors.InvalidArgumentError,
        match=r"variant is coins, must be one of coin_random \(coinrun\), "
        r"cheese_corner \(maze\), two_objects \(maze\), gravity=0.2 \(climber\)",
    ):
        Pool("coinrun", 1, variant="coins")
    with pytest.raises(
        errors.InvalidArgumentError,
        match="variant is coin_random, maze has cheese_corner, two_objects",
    ):
        ProcgenVectorEnv("maze", 1, variant="coin_random")
    with pytest.raises(errors.InvalidArgumentError, match="bigfish has no variants"):
        Pool("bigfish", 1, variant="coin_random")
    with pytest.raises(
        errors.InvalidArgumentError,
        match=r"variant is gravity=9, the value of coinrun is in \[0.05, 0.8\]",
    ):
        Pool("coinrun", 1, variant="gravity=9")
    with pytest.raises(errors.InvalidArgumentError, match="variant is 3; it is text"):
        Pool("coinrun", 1, variant=3)


def test_servers_list_variants_and_reject_other_games(client: Client) -> None:
    listed = [(game.name, each.name) for game in client.catalog().games for each in game.variants]
    assert listed == _VARIANTS
    with pytest.raises(
        errors.InvalidArgumentError,
        match="variant is coin_random, maze has cheese_corner, two_objects",
    ):
        client.create_pool("maze", 1, variant="coin_random")
