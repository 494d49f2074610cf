"""Objects of environments as arrays, in each place."""

from __future__ import annotations

import numpy as np
from conftest import MakePool

from procgen_client import decode_state, goal_positions
from procgen_client.objects import COLUMNS, kinds


def test_rows_are_the_agent_the_goals_and_the_other_entities(make_pool: MakePool) -> None:
    pool = make_pool("coinrun", 3, distribution_mode="easy", rand_seed=2)
    pool.step([7] * 3, repeat_count=5)
    objects = pool.objects(32)
    assert objects.values.shape == (3, 32, len(COLUMNS))
    assert objects.values.dtype == np.float32
    for i, snapshot in enumerate(pool.save_states()):
        state = decode_state(snapshot)
        rows = [state["agent"], *state["entities"]]
        names = objects.names(i)
        assert names[:2] == ["agent", "coin"]
        assert names[2:] == [entity["kind"] for entity in state["entities"]][:30]
        assert objects.counts[i] == len(rows) + 1
        for column in ("x", "y", "vx", "vy", "rx", "ry"):
            values = getattr(objects, column)[i]
            assert values[0] == np.float32(rows[0][column])
            for row, value in zip(rows[1:], values[2:]):
                assert value == np.float32(row[column])
        assert [tuple(objects.values[i, 1, 2:4])] == goal_positions(state)
    assert np.array_equal(objects.positions_of("coin"), objects.values[:, 1, 2:4])
    unused = objects.kind < 0
    assert np.all(objects.values[unused][:, 1:] == 0)


def test_slices_and_several_games(make_pool: MakePool) -> None:
    pool = make_pool(["maze", "heist"], 4, distribution_mode="easy", rand_seed=2)
    whole = pool.objects(8)
    assert whole.games == ("maze", "heist", "maze", "heist")
    part = pool.objects(8, first_env=1, env_count=2)
    assert part.games == ("heist", "maze")
    assert np.array_equal(part.values, whole.values[1:3])
    cheese = whole.positions_of("cheese")
    assert np.isnan(cheese[1]).all() and not np.isnan(cheese[0]).any()
    assert whole.kind[0, 1] == kinds("maze")["cheese"]
    assert whole.kind[1, 1] == kinds("heist")["gem"]
