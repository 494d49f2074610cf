"""Saving, restoring and cloning states, through pools and through the vector environment."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from conftest import server_binary

from procgen_client import Batch, Client, Pool, ProcgenVectorEnv, ServerProcess, connect, errors

_N = 4


def assert_same(one: Batch, other: Batch) -> None:
    for name in ("rewards", "first", "terminated", "level_seeds", "observations", "fingerprints"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)


def random_actions(step_count: int) -> np.ndarray:
    return np.random.default_rng(5).integers(-1, 15, (step_count, _N))


@pytest.fixture
def pool(client: Client) -> Iterator[Pool]:
    with client.create_pool("coinrun", _N, distribution_mode="easy", rand_seed=3) as made:
        made.step([7] * _N)
        yield made


@pytest.fixture
def env(client: Client) -> Iterator[ProcgenVectorEnv]:
    made = ProcgenVectorEnv("coinrun", _N, server=client, autoreset_mode="Disabled", rand_seed=3)
    made.reset()
    yield made
    made.close()


def test_restored_pool_continues_as_the_saved_one(pool: Pool) -> None:
    states = pool.save_states()
    before = [pool.observe()] + [pool.step(actions) for actions in random_actions(40)]
    pool.restore_states(states)
    after = [pool.observe()] + [pool.step(actions) for actions in random_actions(40)]
    for one, other in zip(before, after, strict=True):
        assert_same(one, other)
    assert sum(len(batch.fingerprints) for batch in after) > 0


def test_states_can_be_restored_on_another_server(pool: Pool) -> None:
    with (
        ServerProcess(server_binary(), ["--workers=1"]) as server,
        connect(server.address) as client,
        client.create_pool("coinrun", _N + 1, rand_seed=77) as other,
    ):
        other.restore_states(dict(enumerate(pool.save_states())))
        for actions in random_actions(20):
            whole = pool.step(actions)
            assert_same(whole, other.step(actions, env_count=_N))


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


def test_states_are_cloned_within_and_between_pools(
    client: Client, server: ServerProcess, pool: Pool
) -> None:
    states = pool.save_states()
    pool.clone_states([(0, 1), (1, 0)])
    assert pool.save_states() == [states[1], states[0], *states[2:]]
    with client.create_pool("coinrun", 3) as other:
        other.clone_states([(2, 0), (2, 1)], source_pool=pool)
        other.clone_states([(3, 2)], source_pool=pool.name, source_server=server.address)
        assert other.save_states() == [states[2], states[2], states[3]]


def test_large_states_are_split_into_several_messages(client: Client) -> None:
    with (
        ServerProcess(server_binary(), ["--request_bytes_max=65536", "--response_bytes_max=65536"])
        as server,
        connect(server.address) as small,
        small.create_pool("bigfish", 200, rand_seed=1) as pool,
    ):
        states = pool.save_states()
        assert sum(map(len, states)) > 2 * 65536
        pool.step([-1] * 200)
        pool.restore_states(states)
        assert pool.save_states() == states


def test_invalid_states_are_rejected_and_change_nothing(client: Client, pool: Pool) -> None:
    before = pool.save_states()
    with pytest.raises(errors.InvalidArgumentError, match="states has 3 entries; there are 4"):
        pool.restore_states(before[:3])
    with pytest.raises(errors.InvalidArgumentError, match="environments 0 to 3"):
        pool.restore_states({4: before[0]})
    with pytest.raises(errors.InvalidArgumentError, match="State has a wrong value"):
        pool.restore_states({0: 5})
    with pytest.raises(errors.DataLossError, match="environment 1"):
        pool.restore_states({0: before[2], 1: before[1][:-1]})
    with (
        client.create_pool("maze", 1) as maze,
        pytest.raises(errors.FailedPreconditionError, match="game is maze"),
    ):
        pool.clone_states([(0, 0)], source_pool=maze)
    with pytest.raises(errors.UnavailableError, match="source_server 127.0.0.1:1 cannot be"):
        pool.clone_states([(0, 0)], source_server="127.0.0.1:1")
    with pytest.raises(errors.InvalidArgumentError, match="at most once"):
        pool.save_states([0, 0])
    assert pool.save_states() == before


def test_state_calls_are_rejected_while_requests_are_in_flight(pool: Pool) -> None:
    states = pool.save_states()
    pool.send_step([7] * _N)
    for call in (pool.save_states, lambda: pool.restore_states(states)):
        with pytest.raises(errors.FailedPreconditionError, match="receive them first"):
            call()
    with pytest.raises(errors.FailedPreconditionError, match="receive them first"):
        pool.clone_states([(0, 1)])
    pool.receive()
    pool.restore_states(states)


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


def test_autoreset_episode_is_not_over(
    client: Client, env: ProcgenVectorEnv
) -> None:
    with client.create_pool("coinrun", 1) as same_step:
        same_step.step([-1])
        env.clone_states([(0, 2)], source_pool=same_step)
    env.step([4] * _N)


def test_reset_after_a_restore_starts_another_level(client: Client) -> None:
    env = ProcgenVectorEnv("coinrun", 1, server=client)
    env.restore_states(env.save_states())
    _, before = env.restore_states(env.save_states())
    _, after = env.reset()
    assert after["level_seed"][0] != before["level_seed"][0]
    env.close()
