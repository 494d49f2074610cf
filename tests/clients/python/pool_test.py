"""Stepping, in this process and on a server: batches, slices, resets, requests ahead, errors."""

from __future__ import annotations

import os
import signal
import threading
import time
from typing import Any

import numpy as np
import pytest
from conftest import ROWS, MakePool, assert_same

from procgen_client import Pool, Reset, errors

_NOTHING = 4
_END = -1


def random_actions(step_count: int, env_count: int) -> np.ndarray:
    return np.random.default_rng(5).integers(-1, 15, (step_count, env_count))


def twin_of(make_pool: MakePool, pool: Pool) -> Pool:
    return make_pool(pool.games, pool.env_count, **pool.options)


@pytest.fixture
def pool(make_pool: MakePool) -> Pool:
    return make_pool("coinrun", 6, distribution_mode="easy", rand_seed=3)


def test_first_observation_starts_every_episode(pool: Pool) -> None:
    batch = pool.observe()
    assert (batch.first_env, batch.env_count) == (0, 6)
    assert batch.first.all()
    assert not batch.ended.any()
    assert not batch.rewards.any()
    assert batch.observations.reshape(6, -1).any(axis=1).all()


def test_observe_changes_nothing(pool: Pool) -> None:
    for _ in range(2):
        first = pool.observe()
        assert_same(first, pool.observe())
        pool.step([7] * 6)


def test_attributes_are_what_was_given_and_drawn(make_pool: MakePool, place: object) -> None:
    pool = make_pool(["maze", "coinrun"], 4, num_levels=7, autoreset_mode="next_step")
    assert pool.games == ("maze", "coinrun")
    assert (pool.env_count, pool.autoreset_mode, pool.in_flight) == (4, "next_step", 0)
    assert pool.options["num_levels"] == 7
    assert isinstance(pool.options["rand_seed"], int)
    assert pool.options["rand_seed"] != make_pool("maze", 1).options["rand_seed"]
    assert pool.observation_shape == (64, 64, 3)
    assert pool.client is place
    assert pool.name.startswith("pools/") == (place is not None)
    assert repr(pool).endswith(": 4 x maze,coinrun>")


def test_arrays_have_the_documented_shapes_and_types(pool: Pool) -> None:
    batch = pool.step([_NOTHING] * 6, final_observations=True)
    types = {"rewards": "float32", "episode_returns": "float32", "fingerprints": "uint64"}
    types |= dict.fromkeys(("level_seeds", "prev_level_seeds", "episode_lengths"), "int32")
    for name in (*ROWS, "fingerprints"):
        array = getattr(batch, name)
        assert (array.dtype.name, array.shape) == (types.get(name, "bool"), (6,)), name
    for array in (batch.observations, batch.final_observations):
        assert (array.dtype.name, array.shape) == ("uint8", (6, 64, 64, 3))
    assert pool.step([_NOTHING] * 6).final_observations is None


def test_arrays_that_are_kept_are_writable_and_never_change(pool: Pool) -> None:
    kept, copies = [], []
    for actions in random_actions(30, 6):
        batch = pool.step(actions)
        arrays = [getattr(batch, name) for name in (*ROWS, "fingerprints")]
        assert all(array.flags.writeable for array in arrays)
        kept.append([*arrays, batch.observations[1:3]])  # A view of part of an array.
        copies.append([array.copy() for array in kept[-1]])
        del batch, arrays
    for arrays, expected in zip(kept, copies, strict=True):
        for array, copy in zip(arrays, expected, strict=True):
            np.testing.assert_array_equal(array, copy)


def test_part_of_a_larger_set_plays_its_episodes(make_pool: MakePool) -> None:
    games, options = ["maze", "bigfish"], {"rand_seed": 2, "distribution_mode": "easy"}
    whole = make_pool(games, 6, **options)
    part = make_pool(games, 3, first_env=2, total_env_count=6, **options)
    assert_same(part.observe(), whole.observe(), slice(2, 5))
    for actions in random_actions(20, 6):
        assert_same(part.step(actions[2:5]), whole.step(actions), slice(2, 5))


def test_requests_sent_ahead_return_equal_batches(make_pool: MakePool, pool: Pool) -> None:
    steps = random_actions(30, 6)
    ahead = twin_of(make_pool, pool)
    sent = iter(steps)
    for _ in range(3):
        ahead.send_step(next(sent), final_observations=True)
    for actions in steps:
        assert_same(ahead.receive(), pool.step(actions, final_observations=True))
        if (following := next(sent, None)) is not None:
            ahead.send_step(following, final_observations=True)
            assert ahead.in_flight == 3
    assert ahead.in_flight == 0


def test_two_slices_equal_the_whole_pool(make_pool: MakePool, pool: Pool) -> None:
    halves = twin_of(make_pool, pool)
    for actions in random_actions(20, 6):
        whole = pool.step(actions)
        halves.send_step(actions[:2], env_count=2)
        halves.send_step(actions[2:], first_env=2)
        for rows in (slice(0, 2), slice(2, 6)):
            batch = halves.receive()
            assert batch.first_env == rows.start
            assert_same(batch, whole, rows)


def test_batches_of_several_answers_are_whole(make_pool: MakePool) -> None:
    pool = make_pool("maze", 700, rand_seed=1)
    halves = twin_of(make_pool, pool)
    actions = random_actions(1, 700)[0]
    batch = pool.step(actions, final_observations=True)
    assert batch.observations.reshape(700, -1).any(axis=1).all()
    assert 10 < batch.ended.sum() < 100
    for rows in (slice(0, 350), slice(350, 700)):
        arguments = {"first_env": rows.start, "env_count": 350, "final_observations": True}
        assert_same(halves.step(actions[rows], **arguments), batch, rows)


def test_repeated_action_equals_single_steps(make_pool: MakePool, pool: Pool) -> None:
    singles = [pool.step([7] * 6) for _ in range(5)]
    batch = twin_of(make_pool, pool).step([7] * 6, repeat_count=5)
    # The repetition stops where an episode ends.
    whole = ~np.any([single.ended for single in singles], axis=0)
    assert whole.any()
    rewards = np.sum([single.rewards for single in singles], axis=0)
    np.testing.assert_array_equal(batch.rewards[whole], rewards[whole])
    np.testing.assert_array_equal(batch.observations[whole], singles[-1].observations[whole])
    assert batch.episode_lengths[whole].tolist() == [5] * whole.sum()


def test_action_minus_one_does_nothing_and_ends_the_episode(
    make_pool: MakePool, pool: Pool
) -> None:
    twin = twin_of(make_pool, pool)
    twin.step([7] * 6)
    before = pool.step([7] * 6)
    batch = pool.step([_END, *[_NOTHING] * 5], final_observations=True)
    for flags in (batch.ended, batch.first, batch.terminated):
        assert flags.tolist() == [True] + [False] * 5
    assert batch.prev_level_seeds[0] == before.level_seeds[0]
    assert batch.episode_lengths[0] == 2
    still = twin.step([_NOTHING] * 6)
    np.testing.assert_array_equal(batch.final_observations[0], still.observations[0])


def test_time_limit_truncates(make_pool: MakePool) -> None:
    batch = make_pool("maze", 2).step([_NOTHING] * 2, repeat_count=1000, observe=False)
    assert batch.truncated.all()
    assert not batch.terminated.any()
    assert batch.episode_lengths.tolist() == [500, 500]


def test_autoreset_modes_differ_in_when_the_next_episode_starts(make_pool: MakePool) -> None:
    options = {"distribution_mode": "easy", "rand_seed": 3}
    same, following, never = (
        make_pool("maze", 2, autoreset_mode=mode, **options)
        for mode in ("same_step", "next_step", "disabled")
    )
    last = following.observe()
    for pool in (same, following, never):
        batch = pool.step([_END, _NOTHING])
        assert batch.ended.tolist() == [True, False]
        assert batch.first.tolist() == [pool is same, False]
        if pool is not same:
            np.testing.assert_array_equal(batch.observations[0], last.observations[0])
    started = following.step([7, _NOTHING])
    assert started.first.tolist() == [True, False]
    assert started.rewards[0] == 0
    assert started.level_seeds[0] == same.observe().level_seeds[0]
    with pytest.raises(errors.FailedPreconditionError, match="ended|over"):
        never.step([_NOTHING] * 2)
    assert never.reset([0]).first.tolist() == [True, False]
    assert never.step([_NOTHING] * 2).episode_lengths.tolist() == [1, 2]


def test_next_levels_are_played_after_the_episode(pool: Pool) -> None:
    pool.step([_NOTHING] * 6, next_levels={1: 99})
    batch = pool.step([_END] * 6, next_levels={2: 1234, 5: -7})
    assert batch.level_seeds[[1, 2, 5]].tolist() == [99, 1234, -7]
    assert not {99, 1234, -7} & set(pool.step([_END] * 6).level_seeds.tolist())


def test_reset_affects_only_its_environments(pool: Pool) -> None:
    before = pool.step([7] * 6)
    batch = pool.reset([1, Reset(3, level_seed=77)])
    assert batch.first.tolist() == [False, True, False, True, False, False]
    assert batch.level_seeds[3] == 77
    others = [0, 2, 4, 5]
    np.testing.assert_array_equal(batch.observations[others], before.observations[others])
    assert pool.reset(first_env=4).first.tolist() == [True, True]
    assert pool.observe().first.tolist() == [False, True, False, True, True, True]
    assert pool.reset().first.all()


def test_reset_with_rand_seed_repeats_the_levels(pool: Pool) -> None:
    resets = [Reset(i, rand_seed=9 + i) for i in range(6)]
    first = pool.reset(resets)
    seeds = [first.level_seeds.tolist(), pool.step([_END] * 6).level_seeds.tolist()]
    again = pool.reset(resets)
    np.testing.assert_array_equal(first.observations, again.observations)
    assert seeds == [again.level_seeds.tolist(), pool.step([_END] * 6).level_seeds.tolist()]


def test_environments_reset_in_a_step_are_not_stepped(pool: Pool) -> None:
    batch = pool.step([7] * 6, resets=[Reset(4, level_seed=5), 1])
    assert batch.first.tolist() == [False, True, False, False, True, False]
    assert batch.level_seeds[4] == 5
    assert batch.episode_lengths.tolist() == [1, 0, 1, 1, 0, 1]
    assert pool.step([7] * 6).episode_lengths.tolist() == [2, 1, 2, 2, 1, 2]


def test_calls_that_wait_are_rejected_while_requests_are_in_flight(pool: Pool) -> None:
    pool.send_observe()
    for call in (lambda: pool.step([_NOTHING] * 6), pool.observe, pool.reset, pool.render):
        with pytest.raises(errors.FailedPreconditionError, match="1 requests .*receive"):
            call()
    assert pool.receive().first.all()
    with pytest.raises(errors.FailedPreconditionError, match="no request is unanswered: send one"):
        pool.receive()
    assert pool.step([_NOTHING] * 6).episode_lengths.tolist() == [1] * 6


@pytest.mark.parametrize(
    ("actions", "message"),
    [
        ([_NOTHING] * 7, r"actions has shape \[7\] and type int64; .* of 6 environments from 0 on"),
        ([], r"actions has shape \[0\]"),
        ([[_NOTHING] * 6], r"actions has shape \[1, 6\]"),
        ([0.5] * 6, "float64"),
        ([0, 0, 15, 0, 0, 0], r"\b15\b"),
        ([0, -2, 0, 0, 0, 0], r"-2\b"),
        ([0, 0, 0, 0, 0, 2**32 + 4], "actions contains 4294967300; actions are -1 ... 14"),
    ],
)
def test_invalid_actions_are_rejected_and_change_nothing(
    pool: Pool, actions: list[object], message: str
) -> None:
    before = pool.step([7] * 6)
    with pytest.raises(errors.InvalidArgumentError, match=message):
        pool.step(actions)
    assert pool.in_flight == 0
    assert_same(before, pool.observe())


@pytest.mark.parametrize(
    ("method", "arguments", "message"),
    [
        ("step", {"actions": [4] * 6, "repeat_count": 1001}, r"repeat_count is 1001; .* \[1, 1000"),
        ("step", {"actions": [4] * 6, "repeat_count": 0}, "repeat_count is 0"),
        ("step", {"actions": [4] * 6, "next_levels": {6: 0}}, r"\b6\b"),
        ("step", {"actions": [4] * 6, "next_levels": {0: 2**31}}, "level_seed is 2147483648"),
        ("step", {"actions": [4] * 6, "resets": [9]}, r"\b9\b"),
        ("step", {"actions": [4] * 2, "env_count": 2, "resets": [4]}, r"\b4\b"),
        ("observe", {"first_env": 6}, "first_env is 6; the pool has environments 0 ... 5"),
        ("observe", {"first_env": 1, "env_count": 6}, "env_count is 6 from environment 1"),
        ("observe", {"env_count": 0}, "env_count is 0"),
        ("reset", {"resets": [2, 2]}, r"\b2\b"),
        ("reset", {"resets": []}, "reset"),
        ("reset", {"resets": [Reset(1.5)]}, "environment is 1.5; it is an integer"),
        ("reset", {"resets": [Reset(1, rand_seed=2**32)]}, "rand_seed is 4294967296"),
        ("render", {"size_px": 4}, r"size_px is 4; it is in \[16, 2048\]"),
        ("render", {"environments": [6]}, "environment is 6"),
    ],
)
def test_invalid_requests_are_rejected_and_change_nothing(
    pool: Pool, method: str, arguments: dict[str, Any], message: str
) -> None:
    before = pool.step([7] * 6)
    with pytest.raises(errors.InvalidArgumentError, match=message):
        getattr(pool, method)(**arguments)
    assert pool.in_flight == 0
    assert_same(before, pool.observe())
    assert pool.step([7] * 6).episode_lengths.max() == 2


def test_games_that_do_not_exist_and_modes_that_a_game_has_not_are_named(
    make_pool: MakePool,
) -> None:
    with pytest.raises(errors.NotFoundError, match="pong"):
        make_pool("pong", 2)
    with pytest.raises(errors.InvalidArgumentError, match="bigfish"):
        make_pool("bigfish", 2, distribution_mode="memory")


def test_closed_pool_says_so(make_pool: MakePool) -> None:
    pool = make_pool("maze", 2)
    pool.send_step([4, 4])
    pool.close()
    pool.close()
    assert pool.closed
    assert pool.in_flight == 0
    calls = (lambda: pool.step([4, 4]), pool.observe, pool.reset, pool.receive, pool.save_states)
    for call in calls:
        with pytest.raises(errors.FailedPreconditionError, match="the pool is closed"):
            call()


@pytest.mark.parametrize(("env_count", "repeat_count"), [(4096, 100), (1024, 330)])
def test_ctrl_c_ends_a_wait_and_the_pool_continues(
    make_pool: MakePool, env_count: int, repeat_count: int
) -> None:
    """The step takes half a second, of which the first wait is interrupted."""
    pool = make_pool("coinrun", env_count, distribution_mode="easy")
    actions = np.full(env_count, _NOTHING)
    for _ in range(10):  # Of which one is soon: the machine may be busy.
        sent: list[float] = []

        def interrupt(sent: list[float] = sent) -> None:
            sent.append(time.monotonic())
            os.kill(os.getpid(), signal.SIGINT)

        timer = threading.Timer(0.05, interrupt)
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            pool.step(actions, repeat_count=repeat_count, observe=False)
        duration = time.monotonic() - sent[0]
        timer.join()
        assert pool.in_flight == 0
        lengths = pool.observe(observe=False).episode_lengths
        assert lengths.max() == repeat_count, "the step was taken"
        if duration < 0.1:
            return
        pool.reset(observe=False)
    pytest.fail(f"{duration:.2f} s")


def test_render_draws_at_any_size_and_changes_nothing(make_pool: MakePool, pool: Pool) -> None:
    before = pool.observe()
    frames = pool.render(size_px=512)
    assert [frame.shape for frame in frames] == [(512, 512, 3)] * 6
    assert [frame.shape for frame in pool.render([5, 0], size_px=100)] == [(100, 100, 3)] * 2
    np.testing.assert_array_equal(pool.render([5, 0])[1], frames[0])
    whole = make_pool("coinrun", 1, distribution_mode="easy", rand_seed=3, center_agent=False)
    np.testing.assert_array_equal(pool.render([0], whole_level=True), whole.render([0]))
    assert_same(before, pool.observe())
