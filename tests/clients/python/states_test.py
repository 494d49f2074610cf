"""Saving, restoring and cloning states, through pools and through the vector environment."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from conftest import MakePool, assert_same

from procgen_client import Client, Pool, ProcgenVectorEnv, errors

_N = 4


def random_actions(step_count: int) -> np.ndarray:
    return np.random.default_rng(5).integers(-1, 15, (step_count, _N))


@pytest.fixture
def pool(make_pool: MakePool) -> Pool:
    made = make_pool("coinrun", _N, distribution_mode="easy", rand_seed=3)
    made.step([7] * _N)
    return made


@pytest.fixture
def env(place: Client | None) -> Iterator[ProcgenVectorEnv]:
    with ProcgenVectorEnv("coinrun", _N, server=place, autoreset_mode="Disabled") as made:
        made.reset()
        yield made


def test_restored_pool_continues_as_the_saved_one(pool: Pool) -> None:
    states = pool.save_states()
    before = [pool.observe()] + [pool.step(actions) for actions in random_actions(40)]
    pool.restore_states(states)
    after = [pool.observe()] + [pool.step(actions) for actions in random_actions(40)]
    for one, other in zip(before, after, strict=True):
        assert_same(one, other)
    assert any(batch.ended.any() for batch in after)


def test_states_continue_in_another_pool_and_in_the_other_place(
    client: Client, pool: Pool
) -> None:
    states = pool.save_states()
    others = [client.create_pool("coinrun", _N + 1), Pool("coinrun", _N + 1, server=None)]
    for other in others:
        other.restore_states(dict(enumerate(states)))
    for actions in random_actions(40):
        batch = pool.step(actions)
        for other in others:
            assert_same(batch, other.step(actions, env_count=_N))
    for other in others:
        assert other.save_states(range(_N)) == pool.save_states()
        other.close()


def test_restore_affects_only_the_given_environments(pool: Pool) -> None:
    states = pool.save_states([2, 0])
    assert states == [pool.save_states()[2], pool.save_states()[0]]
    assert pool.save_states([]) == []
    saved = pool.observe()
    after = pool.step([-1] * _N)
    pool.restore_states({2: states[0]})
    mixed = pool.observe()
    np.testing.assert_array_equal(mixed.observations[2], saved.observations[2])
    others = [0, 1, 3]
    np.testing.assert_array_equal(mixed.observations[others], after.observations[others])


def test_states_are_cloned_within_a_pool(pool: Pool) -> None:
    states = pool.save_states()
    pool.clone_states([(0, 1), (1, 0), (0, 3)])
    assert pool.save_states() == [states[1], states[0], states[2], states[0]]
    pool.clone_states([])
    with pytest.raises(errors.InvalidArgumentError):
        pool.clone_states([(0, 2), (1, 2)])
    with pytest.raises(errors.InvalidArgumentError):
        pool.clone_states([(0, _N)])
    assert pool.save_states() == [states[1], states[0], states[2], states[0]]


def test_games_of_cloned_environments_are_equal(make_pool: MakePool) -> None:
    pool = make_pool(["maze", "coinrun"], 4)
    states = pool.save_states()
    for target in (1, 3):
        with pytest.raises(errors.FailedPreconditionError, match="game"):
            pool.clone_states([(0, 2), (0, target)])
        with pytest.raises(errors.FailedPreconditionError, match="game"):
            pool.restore_states({0: states[0], target: states[2]})
    assert pool.save_states() == states


def test_invalid_states_are_rejected_and_change_nothing(pool: Pool) -> None:
    before = pool.save_states()
    with pytest.raises(errors.InvalidArgumentError, match="states has 3 entries; there are 4"):
        pool.restore_states(before[:3])
    with pytest.raises(errors.InvalidArgumentError, match="4"):
        pool.restore_states({0: before[1], 4: before[0]})
    with pytest.raises(errors.InvalidArgumentError, match="a state is int; it is bytes"):
        pool.restore_states({0: 5})
    for damaged in (before[1][:-1], b"", b"x" * 100, before[1][:50] + b"?" + before[1][51:]):
        with pytest.raises(errors.DataLossError):
            pool.restore_states({0: before[2], 1: damaged})
    for environments in ([0, 0], [_N], [-1]):
        with pytest.raises(errors.InvalidArgumentError):
            pool.save_states(environments)
    assert pool.save_states() == before


def test_vector_environment_returns_restored_observations_and_infos(env: ProcgenVectorEnv) -> None:
    saved_observations, *_, saved_infos = env.step([7] * _N)
    states = env.save_states()
    env.step([2] * _N)
    observations, infos = env.restore_states(states)
    np.testing.assert_array_equal(observations, saved_observations)
    np.testing.assert_array_equal(infos["level_seed"], saved_infos["level_seed"])
    assert infos["_level_seed"].all()
    observations, _ = env.clone_states([(0, i) for i in range(1, _N)])
    for observation in observations:
        np.testing.assert_array_equal(observation, saved_observations[0])


def test_restored_state_includes_whether_the_episode_is_over(env: ProcgenVectorEnv) -> None:
    running = env.save_states()
    env.step([4, -1, 4, 4])
    ended = env.save_states()
    env.restore_states(running)
    env.step([4] * _N)
    env.restore_states({3: ended[1]})
    with pytest.raises(errors.FailedPreconditionError, match=r"\[3\] are over"):
        env.step([4] * _N)
    env.reset(options={"reset_mask": np.array([False, False, False, True])})
    env.step([4] * _N)


def test_autoreset_episode_is_not_over(make_pool: MakePool, env: ProcgenVectorEnv) -> None:
    same_step = make_pool("coinrun", 1)
    same_step.step([-1])
    env.restore_states({2: same_step.save_states()[0]})
    env.step([4] * _N)


def test_reset_after_a_restore_starts_another_level(place: Client | None) -> None:
    with ProcgenVectorEnv("coinrun", 1, server=place) as env:
        env.restore_states(env.save_states())
        _, before = env.restore_states(env.save_states())
        _, after = env.reset()
        assert after["level_seed"][0] != before["level_seed"][0]
