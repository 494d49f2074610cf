"""Each environment plays the same number of episodes; policies may be recurrent."""

from __future__ import annotations

import numpy as np

from procgen_client import Pool
from procgen_client.tools.play_episodes import play_episodes

_OPTIONS = {"distribution_mode": "easy", "rand_seed": 5}


def _right(observations: np.ndarray) -> np.ndarray:
    return np.full(len(observations), 7)


def test_episodes_are_the_first_of_each_environment() -> None:
    played = play_episodes(
        "coinrun", _right, env_count=4, episodes_per_env=3, num_levels=3, **_OPTIONS
    )
    expected: list[list[tuple]] = [[] for _ in range(4)]
    with Pool("coinrun", 4, num_levels=3, **_OPTIONS) as pool:
        while min(map(len, expected)) < 3:
            batch = pool.step([7] * 4)
            for i in np.flatnonzero(batch.ended):
                expected[i].append(
                    (
                        *(i, batch.prev_level_seeds[i], batch.episode_returns[i]),
                        *(batch.episode_lengths[i], batch.prev_level_complete[i]),
                    )
                )
    assert [list(map(tuple, each)) for each in played] == [each[:3] for each in expected]
    assert {episode.level_seed for each in played for episode in each} <= {0, 1, 2}


class _Recurrent:
    """Counts the steps of each episode."""

    def __init__(self) -> None:
        self.steps = np.zeros(3, int)
        self.lengths: list[list[int]] = [[], [], []]

    def __call__(self, observations: np.ndarray, first: np.ndarray) -> np.ndarray:
        for i in np.flatnonzero(first & (self.steps > 0)):
            self.lengths[i].append(int(self.steps[i]))
        self.steps[first] = 0
        self.steps += 1
        return np.where(self.steps % (np.arange(3) + 5) == 0, -1, 7)


def test_recurrent_policy_gets_the_starts_of_episodes() -> None:
    policy = _Recurrent()
    played = play_episodes(
        "bigfish", policy, env_count=3, episodes_per_env=4, **_OPTIONS
    )
    lengths = [[episode.length for episode in each] for each in played]
    # The last episode's end is not observed by the policy.
    assert [each[:3] for each in policy.lengths] == [each[:3] for each in lengths]
    assert {length for each in lengths for length in each} <= set(range(1, 8))


def test_policy_owns_its_observations() -> None:
    kept: list[tuple[np.ndarray, int]] = []

    def policy(observations: np.ndarray) -> np.ndarray:
        assert observations.flags.writeable
        assert observations.shape == (2, 3, 32, 32, 1)
        kept.append((observations, hash(observations.tobytes())))
        return np.full(2, 7 if len(kept) % 6 else -1)

    play_episodes(
        *("bigfish", policy),
        env_count=2,
        episodes_per_env=2,
        frame_stack=3,
        screen_size=32,
        grayscale_obs=True,
    )
    assert len(kept) == 12
    for observations, value in kept:
        assert hash(observations.tobytes()) == value
