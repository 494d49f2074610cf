"""A double-buffered sampler gives the batches of whole-pool steps, in halves."""

from __future__ import annotations

import sys
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np
import pytest
from conftest import MakePool, assert_same

from procgen_client import DoubleBufferedSampler, Pool, errors

_N = 5  # Halves of two and three environments.
_STEPS = 40


@pytest.fixture
def pool(make_pool: MakePool) -> Pool:
    """A pool whose episodes depend on nothing but the actions."""
    return make_pool("bigfish", _N, distribution_mode="easy", rand_seed=3)


def _actions(t: int) -> np.ndarray:
    return np.where(np.arange(_N) == t % 11, -1, (t // 3 * 2 + np.arange(_N)) % 9)


def test_rollouts_equal_whole_pool_steps(make_pool: MakePool, pool: Pool) -> None:
    sampler = DoubleBufferedSampler(pool)
    assert sampler.halves == (slice(0, 2), slice(2, 5))
    twin = make_pool("bigfish", _N, distribution_mode="easy", rand_seed=3)
    for _ in range(2):
        whole = [twin.observe(), *(twin.step(_actions(t)) for t in range(_STEPS))]
        seen = []
        for t, rows, batch in sampler.rollout(_STEPS):
            seen.append((t, rows))
            assert_same(batch, whole[t], rows)
            if t < _STEPS:
                sampler.send(_actions(t)[rows])
        assert seen == [(t, half) for t in range(_STEPS + 1) for half in sampler.halves]
        assert any(batch.ended.any() for batch in whole)
        assert pool.in_flight == 0
        assert pool.save_states() == twin.save_states()


def test_a_half_may_be_received_before_the_other_is_sent(pool: Pool) -> None:
    sampler = DoubleBufferedSampler(pool)
    before = pool.save_states()
    at_once = []
    for t, rows, batch in sampler.rollout(_STEPS):
        at_once.append(batch.observations.copy())
        if t < _STEPS:
            sampler.send(_actions(t)[rows])
    pool.restore_states(before)
    later = []
    unsent: list[tuple[int, slice]] = []
    for t, rows, batch in sampler.rollout(_STEPS):
        later.append(batch.observations.copy())
        if unsent:
            its_t, its_rows = unsent.pop()
            sampler.send(_actions(its_t)[its_rows], its_rows)
        if t < _STEPS:
            unsent.append((t, rows))
    assert pool.in_flight == 0
    for first, second in zip(at_once, later, strict=True):
        np.testing.assert_array_equal(first, second)


def test_halves_are_sent_in_order(pool: Pool) -> None:
    sampler = DoubleBufferedSampler(pool)
    rollout = sampler.rollout(2)
    next(rollout)
    next(rollout)
    for rows in (None, slice(2, 5), slice(1, 3)):
        with pytest.raises(errors.FailedPreconditionError, match="environments 0 ... 1 are the"):
            sampler.send([1, 1, 1], rows)
    with pytest.raises(errors.FailedPreconditionError, match="environments 0 ... 1 were not sent"):
        next(rollout)
    assert pool.in_flight == 0


def test_pool_steps_a_half_while_the_other_is_processed(pool: Pool) -> None:
    sampler = DoubleBufferedSampler(pool)
    for t, rows, _ in sampler.rollout(3):
        if t < 3:
            sampler.send(_actions(t)[rows])
            assert pool.in_flight == 2, "that of the other half, too"


def test_observations_are_received_in_a_rollout_buffer(pool: Pool) -> None:
    sampler = DoubleBufferedSampler(pool)
    before = pool.save_states()
    buffer = np.zeros((_STEPS + 1, _N, 64, 64, 3), np.uint8)
    for t, rows, batch in sampler.rollout(_STEPS, out=buffer):
        assert np.shares_memory(batch.observations, buffer[t, rows])
        if t < _STEPS:
            sampler.send(_actions(t)[rows])
    pool.restore_states(before)
    latest = np.zeros((_N, 64, 64, 3), np.uint8)
    for t, rows, _ in sampler.rollout(_STEPS, out=latest):
        np.testing.assert_array_equal(latest[rows], buffer[t, rows])
        if t < _STEPS:
            sampler.send(_actions(t)[rows])
    for wrong in (buffer[1:], latest[1:], buffer[..., :1], buffer.astype(np.float32)):
        with pytest.raises(errors.InvalidArgumentError, match="out "):
            sampler.rollout(_STEPS, out=wrong)
    with pytest.raises(errors.InvalidArgumentError, match=r"of shape \[5, 64, 64, 3\]"):
        sampler.rollout(out=buffer)


@pytest.mark.parametrize("place", [None], ids=["process"])  # One on a server belongs to a thread.
def test_halves_are_sent_by_another_thread(pool: Pool) -> None:
    sampler = DoubleBufferedSampler(pool)
    steps = 1000
    sent: dict[int, Future[None]] = {}
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)  # Threads alternate within a line.
    try:
        with ThreadPoolExecutor(1) as executor:
            for t, rows, _ in sampler.rollout(steps):
                if t < steps:
                    sent[rows.start] = executor.submit(sampler.send, _actions(t)[rows], rows)
                for half in sampler.halves:
                    if half != rows and half.start in sent:
                        sent.pop(half.start).result()
    finally:
        sys.setswitchinterval(interval)
    assert pool.in_flight == 0


def test_endless_rollout_may_be_left(pool: Pool) -> None:
    sampler = DoubleBufferedSampler(pool)
    for t, rows, _ in sampler.rollout():
        sampler.send(_actions(t)[rows])
        if t == 2 * _STEPS:
            break
    assert pool.in_flight == 0, "the answers in flight were discarded"
    (_, rows, _), *_ = sampler.rollout(0)
    assert rows == slice(0, 2)


def test_every_half_is_sent_once(pool: Pool) -> None:
    sampler = DoubleBufferedSampler(pool)
    with pytest.raises(errors.FailedPreconditionError, match="no half waits for actions"):
        sampler.send([1, 1])
    rollout = sampler.rollout(1)
    next(rollout)
    with pytest.raises(errors.FailedPreconditionError, match="1 requests are unanswered"):
        next(sampler.rollout(1))
    with pytest.raises(errors.InvalidArgumentError, match=r"actions has shape \[3\] .* of 2 env"):
        sampler.send([1, 1, 1])
    sampler.send([1, 1])
    with pytest.raises(errors.FailedPreconditionError, match="no half waits for actions"):
        sampler.send([1, 1])
    next(rollout)
    with pytest.raises(errors.FailedPreconditionError, match="not environments 0 ... 1"):
        sampler.send([1, 1], slice(0, 2))
    next(rollout)
    with pytest.raises(errors.FailedPreconditionError, match="environments 2 ... 4 were not sent"):
        next(rollout)
    assert pool.in_flight == 0


def test_pools_without_two_halves_are_rejected(make_pool: MakePool) -> None:
    with pytest.raises(errors.InvalidArgumentError, match="1 environment; .* at least 2"):
        DoubleBufferedSampler(make_pool("maze", 1))
    with pytest.raises(errors.InvalidArgumentError, match="step_count is -1"):
        DoubleBufferedSampler(make_pool("maze", 2)).rollout(-1)
