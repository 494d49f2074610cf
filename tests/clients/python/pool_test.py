"""Stepping: batches, pipelined requests, slices, resets, errors on the stream."""

from __future__ import annotations

import functools
import signal
from collections.abc import Iterator

import numpy as np
import pytest

from procgen_client import Batch, Client, Pool, Reset, ServerProcess, errors

_ROWS = (
    "rewards",
    "first",
    "terminated",
    "truncated",
    "level_seeds",
    "prev_level_seeds",
    "prev_level_complete",
    "episode_returns",
    "episode_lengths",
    "observations",
)
_NOTHING = 4
_END = -1


def assert_same(one: Batch, other: Batch) -> None:
    for name in _ROWS:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)


def random_actions(step_count: int, env_count: int) -> np.ndarray:
    return np.random.default_rng(5).integers(0, 15, (step_count, env_count))


@pytest.fixture
def pool(client: Client) -> Iterator[Pool]:
    with client.create_pool("coinrun", 6, distribution_mode="easy", rand_seed=3) as made:
        yield made


def test_first_observation_starts_every_episode(pool: Pool) -> None:
    batch = pool.observe()
    assert batch.first_env == 0
    assert batch.env_count == 6
    assert batch.first.all()
    assert not batch.ended.any()
    assert not batch.rewards.any()
    assert batch.observations.any()


def test_observe_changes_nothing(pool: Pool) -> None:
    first = pool.observe()
    assert_same(first, pool.observe())


def test_arrays_have_the_documented_shapes_and_types(pool: Pool) -> None:
    batch = pool.step([_NOTHING] * 6)
    types = {name: (getattr(batch, name).dtype.name, getattr(batch, name).shape) for name in _ROWS}
    assert types == {
        "rewards": ("float32", (6,)),
        "first": ("bool", (6,)),
        "terminated": ("bool", (6,)),
        "truncated": ("bool", (6,)),
        "level_seeds": ("int32", (6,)),
        "prev_level_seeds": ("int32", (6,)),
        "prev_level_complete": ("bool", (6,)),
        "episode_returns": ("float32", (6,)),
        "episode_lengths": ("int32", (6,)),
        "observations": ("uint8", (6, 64, 64, 3)),
    }
    assert batch.final_observations.shape == (0, 64, 64, 3)


def test_returned_arrays_are_writable_and_do_not_change(pool: Pool) -> None:
    batch = pool.observe()
    before = batch.observations.copy()
    assert all(getattr(batch, name).flags.writeable for name in _ROWS)
    for actions in random_actions(20, 6):
        pool.step(actions)
    np.testing.assert_array_equal(batch.observations, before)


def test_equal_seeds_give_equal_steps(client: Client, pool: Pool) -> None:
    with client.create_pool_from_spec(pool.spec) as twin:
        for actions in random_actions(40, 6):
            assert_same(pool.step(actions), twin.step(actions))


def test_pipelined_requests_return_equal_batches(client: Client, pool: Pool) -> None:
    steps = random_actions(30, 6)
    expected = [pool.step(actions) for actions in steps]
    with client.create_pool_from_spec(pool.spec) as ahead:
        answers = []
        for actions in steps:
            if ahead.in_flight == ahead.requests_in_flight_max:
                answers.append(ahead.receive())
            ahead.send_step(actions)
        answers += [ahead.receive() for _ in range(ahead.in_flight)]
    for one, other in zip(expected, answers, strict=True):
        assert_same(one, other)


def test_two_slices_equal_the_whole_pool(client: Client, pool: Pool) -> None:
    with client.create_pool_from_spec(pool.spec) as halves:
        for actions in random_actions(20, 6):
            whole = pool.step(actions)
            halves.send_step(actions[:2], env_count=2)
            halves.send_step(actions[2:], first_env=2)
            parts = [halves.receive(), halves.receive()]
            assert [part.first_env for part in parts] == [0, 2]
            for name in _ROWS:
                joined = np.concatenate([getattr(part, name) for part in parts])
                np.testing.assert_array_equal(joined, getattr(whole, name), err_msg=name)


def test_batch_in_several_responses_equals_one_in_a_single_response(client: Client) -> None:
    # The smallest response limit has room for five observations: seven responses.
    with (
        client.create_pool("maze", 33, rand_seed=1) as whole,
        client.create_pool("maze", 33, rand_seed=1) as pieces,
    ):
        pieces.attach(response_bytes_max=65536)
        assert_same(whole.observe(), pieces.observe())
        actions = np.full(33, _NOTHING)
        actions[::4] = _END
        one = whole.step(actions, final_observations=True)
        other = pieces.step(actions, final_observations=True)
        assert_same(one, other)
        assert len(one.final_observations) == 9
        np.testing.assert_array_equal(one.final_observations, other.final_observations)


@pytest.mark.parametrize("game", ["bigfish", "maze"])
@pytest.mark.parametrize("env_count", [1, 3, 20])
def test_chunked_steps_equal_whole_ones(
    client: Client, game: str, env_count: int
) -> None:
    options = {"distribution_mode": "easy", "rand_seed": 3}
    rng = np.random.default_rng(2)
    with (
        client.create_pool(game, env_count, chunk_count=1, **options) as whole,
        client.create_pool(game, env_count, chunk_count=3, **options) as chunked,
    ):
        for step in range(20):
            arguments = {
                "final_observations": step % 2 == 0,
                "observe": step % 5 != 4,
                "next_levels": {env_count - 1: step},
                "resets": [Reset(env_count // 2, level_seed=7)] if step % 6 == 5 else [],
            }
            actions = rng.integers(-1, 15, env_count)
            one, other = whole.step(actions, **arguments), chunked.step(actions, **arguments)
            assert_same(one, other)
            np.testing.assert_array_equal(one.final_observations, other.final_observations)
            np.testing.assert_array_equal(one.fingerprints, other.fingerprints)
            assert one.sequence_number == other.sequence_number


def test_only_large_pools_are_chunked_by_default(client: Client) -> None:
    stream = functools.partial(client.create_pool, "maze", transport="stream")
    with stream(16) as small, stream(400) as large:
        assert small.chunk_count == 1
        assert large.chunk_count > 1
        assert client.get_pool(small.name, chunk_count=2).chunk_count == 2
    for chunk_count in (0, 65):
        with pytest.raises(errors.InvalidArgumentError, match=r"it is in \[1, 64\]"):
            client.create_pool("maze", 2, chunk_count=chunk_count)


def test_error_in_the_last_chunk_steps_nothing(client: Client) -> None:
    with client.create_pool("maze", 4, chunk_count=2) as pool:
        with pytest.raises(errors.InvalidArgumentError, match="is 9, the slice is 0 to 3"):
            pool.step([4, 4, 4, 4], resets=[9])
        assert pool.step([4, 4, 4, 4]).episode_lengths.tolist() == [1, 1, 1, 1]


def test_pools_larger_than_a_response_need_no_option(client: Client) -> None:
    with client.create_pool("maze", 700) as pool:
        batch = pool.step(np.full(700, _NOTHING))
    assert batch.observations.shape == (700, 64, 64, 3)
    assert batch.observations.reshape(700, -1).any(axis=1).all()


def test_omitting_observations_changes_no_other_array(client: Client, pool: Pool) -> None:
    with client.create_pool_from_spec(pool.spec) as unseen:
        for actions in random_actions(30, 6):
            seen, other = pool.step(actions), unseen.step(actions, observe=False)
            assert other.observations is None
            np.testing.assert_array_equal(seen.rewards, other.rewards)
            np.testing.assert_array_equal(seen.level_seeds, other.level_seeds)
        assert_same(pool.observe(), unseen.observe())


def test_repeated_action_equals_single_steps(client: Client, pool: Pool) -> None:
    with client.create_pool_from_spec(pool.spec) as repeated:
        singles = [pool.step([7] * 6) for _ in range(5)]
        batch = repeated.step([7] * 6, repeat_count=5)
        # The repetition stops where an episode ends.
        whole = ~np.any([single.ended for single in singles], axis=0)
        assert whole.any()
        rewards = np.sum([single.rewards for single in singles], axis=0)
        np.testing.assert_array_equal(batch.rewards[whole], rewards[whole])
        np.testing.assert_array_equal(
            batch.observations[whole], singles[-1].observations[whole]
        )


def test_action_minus_one_ends_the_episode(pool: Pool) -> None:
    before = pool.observe()
    batch = pool.step([_END, *[_NOTHING] * 5], final_observations=True)
    assert batch.ended.tolist() == [True] + [False] * 5
    assert batch.first.tolist() == [True] + [False] * 5
    assert batch.terminated[0]
    assert batch.prev_level_seeds[0] == before.level_seeds[0]
    assert batch.episode_lengths[0] == 1
    assert batch.final_observations.shape == (1, 64, 64, 3)


def test_time_limit_truncates(client: Client) -> None:
    with client.create_pool("maze", 2) as pool:
        batch = pool.step([_NOTHING] * 2, repeat_count=1000, observe=False)
    assert batch.truncated.all()
    assert not batch.terminated.any()
    assert batch.episode_lengths.tolist() == [500, 500]


def test_next_levels_are_played_after_the_episode(pool: Pool) -> None:
    batch = pool.step([_END] * 6, next_levels={2: 1234, 5: -7})
    assert batch.level_seeds[[2, 5]].tolist() == [1234, -7]


def test_reset_affects_only_its_environments(pool: Pool) -> None:
    before = pool.step([7] * 6)
    batch = pool.reset([1, Reset(3, level_seed=77)])
    assert batch.first.tolist() == [False, True, False, True, False, False]
    assert batch.level_seeds[3] == 77
    others = [0, 2, 4, 5]
    np.testing.assert_array_equal(batch.observations[others], before.observations[others])
    assert pool.reset().first.all()


def test_reset_with_rand_seed_repeats_the_levels(pool: Pool) -> None:
    first = pool.reset([Reset(i, rand_seed=9 + i) for i in range(6)])
    pool.step([_END] * 6)
    again = pool.reset([Reset(i, rand_seed=9 + i) for i in range(6)])
    np.testing.assert_array_equal(first.level_seeds, again.level_seeds)
    np.testing.assert_array_equal(first.observations, again.observations)


def test_environments_reset_in_a_step_are_not_stepped(pool: Pool) -> None:
    batch = pool.step([7] * 6, resets=[Reset(4, level_seed=5)])
    assert batch.first.tolist() == [False] * 4 + [True, False]
    assert batch.level_seeds[4] == 5
    assert batch.episode_lengths.tolist() == [1, 1, 1, 1, 0, 1]


def test_excess_requests_are_rejected_locally(pool: Pool) -> None:
    for _ in range(pool.requests_in_flight_max):
        pool.send_observe()
    with pytest.raises(errors.FailedPreconditionError, match="receive first"):
        pool.send_observe()
    with pytest.raises(errors.FailedPreconditionError, match="receive them first"):
        pool.step([_NOTHING] * 6)
    for _ in range(pool.requests_in_flight_max):
        pool.receive()
    with pytest.raises(errors.FailedPreconditionError, match="send first"):
        pool.receive()


@pytest.mark.parametrize(
    ("actions", "message"),
    [
        ([_NOTHING] * 7, "actions has 7 entries; pools/.* has 6 environments from 0 on"),
        ([_NOTHING], "actions has 1 entries; .* has 6 .*env_count choose a slice"),
        ([], "actions has 0 entries"),
        ([[_NOTHING] * 6], "shape \\[1, 6\\]"),
        ([0.5] * 6, "float64"),
        ([0, 0, 15, 0, 0, 0], "actions\\[2\\] is 15; actions are -1 ... 14"),
        ([0, -2, 0, 0, 0, 0], "actions\\[1\\] is -2"),
    ],
)
def test_invalid_actions_are_rejected_and_change_nothing(
    pool: Pool, actions: list[object], message: str
) -> None:
    before = pool.observe()
    with pytest.raises(errors.InvalidArgumentError, match=message):
        pool.step(actions)
    assert pool.attached
    assert_same(before, pool.observe())


def test_pool_continues_after_a_rejected_request(pool: Pool) -> None:
    before = pool.step([7] * 6)
    with pytest.raises(errors.InvalidArgumentError):
        pool.reset([2, 2])  # Only the server detects the duplicate.
    assert not pool.attached
    assert_same(before, pool.observe())


def test_requests_before_a_rejected_one_are_answered(pool: Pool) -> None:
    pool.send_step([7] * 6)
    pool.send_reset([2, 2])
    answered = pool.receive()
    with pytest.raises(errors.InvalidArgumentError):
        pool.receive()
    assert_same(answered, pool.observe())


def test_pool_has_one_stream_at_a_time(server: ServerProcess, pool: Pool) -> None:
    pool.observe()
    with Client(server.address) as other_client, other_client.get_pool(pool.name) as other:
        with pytest.raises(errors.FailedPreconditionError):
            other.observe()
        pool.detach()
        other.observe()
        with pytest.raises(errors.FailedPreconditionError):
            pool.observe()


def test_deleting_a_pool_aborts_its_stream(client: Client, pool: Pool) -> None:
    pool.observe()
    client.delete_pool(pool.name)
    with pytest.raises((errors.AbortedError, errors.NotFoundError)):
        pool.observe()
    with pytest.raises(errors.NotFoundError):
        pool.observe()


def test_pool_can_be_closed_after_an_interrupted_wait(client: Client) -> None:
    def interrupt(number: int, frame: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        with client.create_pool("caveflyer", 512) as pool:
            for _ in range(2):  # 512,000 steps each, about 0.5 s.
                pool.send_step([_NOTHING] * 512, repeat_count=1000, observe=False)
            with pytest.raises(KeyboardInterrupt):
                signal.setitimer(signal.ITIMER_REAL, 0.02)
                pool.receive()
                pool.receive()
            assert not pool.attached
    finally:
        signal.signal(signal.SIGALRM, before)
    assert pool.name not in [message.name for message in client.list_pools()]


def test_render_draws_at_any_size_and_changes_nothing(client: Client, pool: Pool) -> None:
    if not client.catalog().features.render:
        pytest.skip("this server has no rendering")
    before = pool.observe()
    frames = pool.render(size_px=512)  # Six frames take several messages.
    assert [frame.shape for frame in frames] == [(512, 512, 3)] * 6
    assert [frame.shape for frame in pool.render([5, 0], size_px=100)] == [(100, 100, 3)] * 2
    with client.create_pool(
        "coinrun", 1, distribution_mode="easy", rand_seed=3, center_agent=False
    ) as whole:
        np.testing.assert_array_equal(pool.render([0], whole_level=True), whole.render([0]))
    assert_same(before, pool.observe())
    with pytest.raises(errors.InvalidArgumentError, match="size_px is 4; it is in \\[16, 2048\\]"):
        pool.render(size_px=4)
    with pytest.raises(errors.InvalidArgumentError):
        pool.render([6])
