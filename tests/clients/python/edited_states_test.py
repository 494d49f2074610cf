"""States as dicts: read, changed, written and played."""

from __future__ import annotations


import numpy as np
import pytest
from conftest import MakePool

from procgen_client import (
    Pool,
    State,
    catalog,
    decode_state,
    encode_state,
    errors,
    goal_positions,
    move_goal,
    remove_goals,
)

_RIGHT, _NOTHING = 7, 4


def _state(game: str, **options: object) -> State:
    with Pool(game, 1, distribution_mode="easy", rand_seed=2, **options) as pool:
        return decode_state(pool.save_states()[0])


@pytest.mark.parametrize("game", [each["name"] for each in catalog()["games"]])
def test_decoded_state_gives_the_same_snapshot(game: str) -> None:
    actions = np.random.default_rng(1)
    with Pool(game, 4, distribution_mode="easy", rand_seed=3) as pool:
        for _ in range(5):
            for snapshot in pool.save_states():
                state = decode_state(snapshot)
                assert state["game"] == game
                assert state["edited"] is False
                assert encode_state(state) == snapshot
            pool.step(actions.integers(0, 15, 4), repeat_count=9)


def test_edited_state_is_played_and_marked_until_the_episode_ends(make_pool: MakePool) -> None:
    pool = make_pool("maze", 2, distribution_mode="easy", rand_seed=2)
    state = decode_state(pool.save_states()[0])
    x, y = state["agent"]["x"], state["agent"]["y"]
    grid = np.array(state["grid"], dtype=object)
    grid[grid == "cheese"] = "empty"
    grid[int(y), int(x) + 1] = "cheese"
    state["grid"] = grid
    edited = encode_state(state)
    pool.restore_states({0: edited})
    assert decode_state(pool.save_states()[0])["edited"]
    batch = pool.step([_RIGHT, _NOTHING])
    assert batch.rewards.tolist() == [10, 0]
    assert batch.terminated.tolist() == [True, False]
    assert not decode_state(pool.save_states()[0])["edited"]


def test_an_edit_changes_the_fingerprint() -> None:
    with Pool("maze", 2, distribution_mode="easy", num_levels=1) as pool:
        state = decode_state(pool.save_states()[0])
        remove_goals(state)
        pool.restore_states({0: encode_state(state)})
        batch = pool.step([-1, -1])
    assert batch.fingerprints[0] != batch.fingerprints[1] != 0


def test_goals_are_cells_or_entities() -> None:
    for game in ("coinrun", "maze", "heist"):
        state = _state(game)
        (old,) = goal_positions(state)
        x, y = state["agent"]["x"], state["agent"]["y"]
        move_goal(state, x, y)
        (new,) = goal_positions(state)
        assert (int(new[0]), int(new[1])) == (int(x), int(y)) != old
        remove_goals(state)
        assert goal_positions(state) == []
        encode_state(state)
    assert goal_positions(_state("starpilot")) == []


def test_goals_without_a_place_are_rejected() -> None:
    state = _state("coinrun")
    with pytest.raises(errors.InvalidArgumentError, match=r"the level is 64 x 64 cells"):
        move_goal(state, 64, 3)
    with pytest.raises(errors.InvalidArgumentError, match=r"is ground_top; a goal needs an empty"):
        move_goal(state, 2.5, 0.5)
    with pytest.raises(errors.InvalidArgumentError, match="the state has 0 goals"):
        move_goal(_state("bigfish"), 2, 2)


def test_what_is_no_snapshot_is_rejected() -> None:
    with pytest.raises(errors.InvalidArgumentError, match="a state is str; it is bytes"):
        decode_state("state")
    with pytest.raises(errors.DataLossError):
        decode_state(b"PGST")
