"""Pools for asyncio: batches equal those of the synchronous pool; other coroutines run."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

import pytest
from conftest import MakePool, assert_same

from procgen_client import Client, ServerProcess, aio, errors

_N = 4
_OPTIONS = {"distribution_mode": "easy", "rand_seed": 2}
_Make = Callable[..., Awaitable[aio.AsyncPool]]


@pytest.fixture
def make(place: Client | None) -> _Make:
    """Makes pools in each place."""
    return lambda games, env_count, **options: aio.create_pool(
        games, env_count, server=place, **options
    )


def test_batches_equal_those_of_the_synchronous_pool(make_pool: MakePool, make: _Make) -> None:
    async def play() -> None:
        pool = make_pool("coinrun", _N, **_OPTIONS)
        async with await make("coinrun", _N, **_OPTIONS) as twin:
            assert_same(pool.observe(), await twin.observe())
            for step in range(30):
                arguments = {
                    "final_observations": step % 2 == 0,
                    "repeat_count": 1 + step % 3,
                    "resets": [1] if step % 7 == 0 else [],
                    "next_levels": {2: step},
                }
                actions = [(step + i) % 16 - 1 for i in range(_N)]
                assert_same(pool.step(actions, **arguments), await twin.step(actions, **arguments))
            assert_same(pool.reset([3]), await twin.reset([3]))
            part = {"first_env": 1, "env_count": 2, "observe": False}
            assert_same(pool.step([1, 2], **part), await twin.step([1, 2], **part))
            await twin.clone_states([(0, 1), (0, 2), (0, 3)])
            pool.restore_states(await twin.save_states())
            assert_same(pool.observe(), await twin.observe())
            await twin.restore_states({3: pool.save_states([2])[0]})
            assert await twin.save_states([]) == []

    asyncio.run(play())


def test_other_coroutines_run_during_a_step(make: _Make) -> None:
    async def play() -> None:
        async with await make("coinrun", 2048) as pool:  # A step of half a second.
            stepping = asyncio.create_task(
                pool.step([4] * 2048, repeat_count=200, observe=False)
            )
            ticks = 0
            while not stepping.done():
                await asyncio.sleep(0.001)
                ticks += 1
            assert (await stepping).episode_lengths.max() == 200
            assert ticks > 10

    asyncio.run(play())


def test_cancelled_task_leaves_the_pool_usable(make: _Make) -> None:
    async def play() -> None:
        async with await make("coinrun", 1024) as pool:
            for count in (1, 2):
                for _ in range(count):
                    await pool.send_step([4] * 1024, repeat_count=100, observe=False)
                waiting = asyncio.create_task(pool.receive())
                await asyncio.sleep(0.01)
                waiting.cancel()
                with pytest.raises(asyncio.CancelledError):
                    await waiting
                batch = await pool.observe(observe=False)
                assert batch.episode_lengths.max() == 100 * (2 * count - 1), "they were taken"

    asyncio.run(play())


def test_closing_a_client_ends_the_calls_of_its_tasks(server: ServerProcess) -> None:
    async def play() -> None:
        for _ in range(2):
            closed = Client(server.address)
            pool = await aio.create_pool("coinrun", 1024, server=closed)
            await pool.send_step([4] * 1024, observe=False, repeat_count=300)
            waiting = asyncio.create_task(pool.receive())
            await asyncio.sleep(0.01)  # It waits now.
            assert not waiting.done()
            closed.close()
            with pytest.raises(errors.CancelledError):
                await asyncio.wait_for(waiting, 20)
            with pytest.raises(errors.CancelledError):
                await pool.observe()
            await pool.close()
        async with await aio.create_pool("maze", 2, server=server) as pool:
            assert (await asyncio.wait_for(pool.observe(), 20)).env_count == 2

    asyncio.run(play())
