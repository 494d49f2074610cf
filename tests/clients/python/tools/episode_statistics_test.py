"""Statistics of ended episodes, from batches or from infos."""

from __future__ import annotations

import math

import numpy as np
import pytest

from procgen_client import Client, EpisodeStatistics, ProcgenVectorEnv, errors

_N = 8
_OPTIONS = {"distribution_mode": "easy", "rand_seed": 4}


def test_episodes_match_the_steps(client: Client) -> None:
    statistics = EpisodeStatistics(window=5)
    assert math.isnan(statistics.mean_return)
    returns, lengths = np.zeros(_N), np.zeros(_N, int)
    episodes, expected = [], []
    with client.create_pool("bigfish", _N, **_OPTIONS) as pool:
        for step in range(200):
            actions = np.random.default_rng(step).integers(-1 if step % 20 == 0 else 0, 15, _N)
            batch = pool.step(actions)
            returns += batch.rewards
            lengths += 1
            episodes += statistics.add(batch)
            for i in np.flatnonzero(batch.ended):
                expected.append((i, batch.prev_level_seeds[i], returns[i], lengths[i]))
                returns[i] = lengths[i] = 0
    assert [episode[:4] for episode in episodes] == expected
    assert statistics.episode_count == len(expected) > 5
    assert list(statistics.recent) == episodes[-5:]
    assert statistics.mean_return == pytest.approx(np.mean([each[2] for each in expected[-5:]]))
    assert statistics.mean_length == pytest.approx(np.mean([each[3] for each in expected[-5:]]))
    assert 0 <= statistics.completed_share <= 1


def test_slices_report_environment_indices(client: Client) -> None:
    with client.create_pool("maze", 4, **_OPTIONS) as pool:
        (episode,) = EpisodeStatistics().add(pool.step([4, -1], first_env=2))
    assert episode.environment == 3
    assert not episode.is_completed


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_infos_and_batches_give_equal_statistics(client: Client, mode: str) -> None:
    of_infos, of_batches = EpisodeStatistics(), EpisodeStatistics()
    with (
        ProcgenVectorEnv("maze", _N, server=client, autoreset_mode=mode, **_OPTIONS) as env,
        client.create_pool(
            "maze", _N, autoreset_mode={"NextStep": "next_step"}.get(mode, "same_step"), **_OPTIONS
        ) as pool,
    ):
        env.reset()
        for step in range(100):
            actions = [-1 if (step + i) % 23 == 22 else step % 15 for i in range(_N)]
            assert of_infos.add(env.step(actions)[4]) == of_batches.add(pool.step(actions))
    assert of_infos.episode_count > _N


def test_empty_window_is_rejected() -> None:
    with pytest.raises(errors.InvalidArgumentError, match="window is 0"):
        EpisodeStatistics(0)
