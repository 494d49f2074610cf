"""The asyncio client: batches equal those of the synchronous client; other coroutines run."""

from __future__ import annotations

import asyncio
import os
import signal
import time
from collections.abc import Awaitable, Callable

import numpy as np
import pytest
from conftest import ENCODINGS, native_only
from fault_proxy import Proxy

from procgen_client import Batch, Client, LevelSampler, ServerProcess, aio, errors

_N = 4
_OPTIONS = {"distribution_mode": "easy", "rand_seed": 2}


def _run(server: ServerProcess, use: Callable[[aio.AsyncClient], Awaitable[None]]) -> None:
    async def connected() -> None:
        async with await aio.connect(server.address) as client:
            await use(client)

    asyncio.run(connected())


def _assert_equal(left: Batch, right: Batch) -> None:
    for name in Batch.__dataclass_fields__:
        np.testing.assert_array_equal(getattr(left, name), getattr(right, name), name)


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_batches_equal_those_of_the_synchronous_client(
    server: ServerProcess, client: Client, encoding: str
) -> None:
    async def play(other: aio.AsyncClient) -> None:
        with client.create_pool("coinrun", _N, **_OPTIONS) as pool:
            async with await other.create_pool(
                "coinrun", _N, encoding=encoding, **_OPTIONS
            ) as twin:
                _assert_equal(pool.observe(), await twin.observe())
                for step in range(30):
                    arguments = {
                        "final_observations": step % 2 == 0,
                        "repeat_count": 1 + step % 3,
                        "resets": [1] if step % 7 == 0 else [],
                        "next_levels": {2: step},
                    }
                    actions = [(step + i) % 16 - 1 for i in range(_N)]
                    _assert_equal(
                        pool.step(actions, **arguments), await twin.step(actions, **arguments)
                    )
                _assert_equal(pool.reset([3]), await twin.reset([3]))
                part = {"first_env": 1, "env_count": 2, "observe": False}
                left = pool.step([1, 2], **part)
                _assert_equal(left, await twin.step([1, 2], **part))

    _run(server, play)


def test_large_batches_are_assembled_from_several_responses(server: ServerProcess) -> None:
    async def play(client: aio.AsyncClient) -> None:
        async with await client.create_pool("maze", 400, **_OPTIONS) as pool:
            assert (await pool.step([4] * 400)).observations.shape == (400, 64, 64, 3)

    _run(server, play)


def test_pipelined_requests_are_answered_in_order(server: ServerProcess) -> None:
    async def play(client: aio.AsyncClient) -> None:
        async with await client.create_pool("maze", _N, requests_in_flight_max=3) as pool:
            for _ in range(3):
                await pool.send_step([4] * _N)
            with pytest.raises(errors.FailedPreconditionError, match="receive first"):
                await pool.send_step([4] * _N)
            with pytest.raises(errors.FailedPreconditionError, match="receive them first"):
                await pool.observe()
            numbers = [(await pool.receive()).sequence_number for _ in range(3)]
            assert numbers == sorted(numbers)
            with pytest.raises(errors.FailedPreconditionError, match="send first"):
                await pool.receive()

    _run(server, play)


def test_pools_are_stepped_concurrently(server: ServerProcess) -> None:
    async def play(client: aio.AsyncClient) -> None:
        async def rollout(seed: int) -> np.ndarray:
            async with await client.create_pool("bigfish", _N, rand_seed=seed) as pool:
                return np.stack([(await pool.step([7] * _N)).rewards for _ in range(50)])

        one, twin, other = await asyncio.gather(rollout(1), rollout(1), rollout(2))
        np.testing.assert_array_equal(one, twin)
        assert other.shape == one.shape
        assert await client.list_pools() == []

    _run(server, play)


def test_observations_are_copied_into_out(server: ServerProcess) -> None:
    async def play(client: aio.AsyncClient) -> None:
        options = {"rand_seed": 3}  # where possible in shared memory
        async with await client.create_pool("bigfish", 4, **options) as pool:
            async with await client.create_pool("bigfish", 4, **options) as twin:
                out = np.zeros((4, 64, 64, 3), np.uint8)
                for call, arguments in (("observe", ()), ("step", ([7] * 4,)), ("reset", ())):
                    batch = await getattr(pool, call)(*arguments, out=out)
                    assert batch.observations is out
                    expected = await getattr(twin, call)(*arguments)
                    np.testing.assert_array_equal(out, expected.observations)
                with pytest.raises(errors.InvalidArgumentError, match=r"out has shape \[3, 64"):
                    await pool.step([7] * 4, out=out[:3])
                with pytest.raises(errors.InvalidArgumentError, match="observe is False"):
                    await pool.step([7] * 4, observe=False, out=out)
                assert pool.in_flight == 0

    _run(server, play)


def test_states_are_saved_restored_and_cloned(server: ServerProcess) -> None:
    async def play(client: aio.AsyncClient) -> None:
        async with await client.create_pool("miner", _N, **_OPTIONS) as pool:
            states = await pool.save_states()
            assert await pool.save_states([]) == []
            before = await pool.step([5] * _N)
            await pool.restore_states(states)
            after = await pool.step([5] * _N)
            np.testing.assert_array_equal(before.observations, after.observations)
            await pool.clone_states([(0, 1), (0, 2), (0, 3)])
            assert len(set((await pool.observe()).level_seeds.tolist())) == 1

    _run(server, play)


def test_errors_are_the_same_and_the_pool_continues(server: ServerProcess) -> None:
    async def play(client: aio.AsyncClient) -> None:
        with pytest.raises(errors.NotFoundError, match="pong"):
            await client.create_pool("pong", 1)
        async with await client.create_pool("maze", 2) as pool:
            with pytest.raises(errors.InvalidArgumentError, match="actions\\[1\\] is 99"):
                await pool.step([4, 99])
            with pytest.raises(errors.InvalidArgumentError, match="actions has 3 entries"):
                await pool.step([4, 4, 4])
            with pytest.raises(errors.InvalidArgumentError, match="actions has 1 entries"):
                await pool.step([4])
            with pytest.raises(errors.InvalidArgumentError, match="next_levels"):
                await pool.step([4, 4], next_levels={9: 1})  # Detected by the server.
            await pool.step([4, 4])

    _run(server, play)


def test_cancelled_task_leaves_the_pool_usable(server: ServerProcess) -> None:
    async def play(client: aio.AsyncClient) -> None:
        async with await client.create_pool("maze", 2) as pool:
            await pool.send_step([4, 4])
            waiting = asyncio.create_task(pool.receive())
            await asyncio.sleep(0)
            waiting.cancel()
            with pytest.raises(asyncio.CancelledError):
                await waiting
            assert (await pool.step([4, 4])).env_count == 2

    _run(server, play)


def test_levels_can_be_sampled(server: ServerProcess) -> None:
    async def play(client: aio.AsyncClient) -> None:
        sampler = LevelSampler([11, 12])
        async with await client.create_pool("maze", 8, level_sampler=sampler) as pool:
            assert set((await pool.observe()).level_seeds.tolist()) <= {11, 12}

    _run(server, play)


def test_missing_server_and_closed_client_are_errors(server: ServerProcess) -> None:
    async def play() -> None:
        with pytest.raises(errors.UnavailableError, match="no server listens at 127.0.0.1:1: "):
            await aio.connect("127.0.0.1:1", timeout=0.3)
        client = await aio.connect(server.address)
        await client.close()
        with pytest.raises(errors.ProcgenError, match="closed"):
            await client.list_pools()

    asyncio.run(play())


def test_closing_a_client_ends_the_calls_of_its_tasks(
    server: ServerProcess, client: Client
) -> None:
    """Tasks end with CancelledError, and the next stream of the event loop is answered."""

    async def play() -> None:
        for _ in range(3):
            closed = await aio.connect(server.address)
            pool = await closed.create_pool("coinrun", 1024)  # A step of a second.
            await pool.send_step([4] * 1024, observe=False, repeat_count=1000)
            waiting = asyncio.create_task(pool.receive())
            await asyncio.sleep(0.01)  # It waits now.
            assert not waiting.done()
            await closed.close()
            with pytest.raises(errors.CancelledError):
                await asyncio.wait_for(waiting, 20)
            with pytest.raises(errors.CancelledError):
                await pool.observe()
            client.delete_pool(pool.name)
        async with await aio.connect(server.address) as other:
            async with await other.create_pool("maze", 2) as pool:
                assert (await asyncio.wait_for(pool.observe(), 20)).env_count == 2

    asyncio.run(play())


@native_only
@pytest.mark.parametrize("encoding", ["raw", "delta_zstd"])
def test_faulty_network_loses_nothing(server: ServerProcess, encoding: str) -> None:
    async def trace(pool: aio.AsyncPool) -> list[Batch]:
        while True:
            try:  # The client does not retry attach.
                await pool.attach(take_over=True, response_bytes_max=65536)
                break
            except errors.ProcgenError:
                pass
        batches: list[Batch] = []
        sent = 0
        while len(batches) < 150:
            while sent < 150 and pool.in_flight < pool.requests_in_flight_max:
                await pool.send_step([(sent // 3 * 7 + i) % 16 - 1 for i in range(12)])
                sent += 1
            batches.append(await pool.receive())
        return batches

    async def play(client: aio.AsyncClient) -> None:
        games = ["maze", "bigfish"]
        async with await client.create_pool(games, 12, **_OPTIONS) as pool:
            expected = await trace(pool)
        proxy = Proxy(server.address, 11, 120_000 if encoding == "raw" else 20_000)
        async with await client.create_pool(
            games, 12, encoding=encoding, transport="stream", **_OPTIONS
        ) as pool:
            learner = None
            while learner is None:
                try:
                    learner = await aio.connect(proxy.address)
                    twin = await learner.get_pool(pool.name, requests_in_flight_max=3)
                except errors.ProcgenError:
                    pass
            actual = await trace(twin)
            await twin.close()
            assert twin.name in [message.name for message in await client.list_pools()]
            await learner.close()
        assert proxy.stop() >= 5
        for left, right in zip(expected, actual, strict=True):
            _assert_equal(left, right)

    _run(server, play)


@native_only
def test_reconnecting_to_a_lost_server_times_out() -> None:
    async def play(server: ServerProcess, timeout: float, words: str) -> None:
        async with await aio.connect(server.address, reconnect_timeout=timeout) as client:
            pool = await client.create_pool("maze", 2)
            await pool.step([4, 4])
            os.kill(server.process_id, signal.SIGKILL)
            begin = time.monotonic()
            with pytest.raises(errors.UnavailableError, match=words):
                while True:
                    await pool.step([4, 4])
            assert time.monotonic() - begin < 10

    for timeout, words in ((0.5, "made again within (500ms|0.5 s)"), (0, "^(?!.*made again)")):
        with ServerProcess(flags=["--workers=1"]) as server:
            asyncio.run(play(server, timeout, words))


def test_draining_server_is_not_contacted_again() -> None:
    async def play(server: ServerProcess) -> None:
        async with await aio.connect(server.address, reconnect_timeout=600) as client:
            pool = await client.create_pool("maze", 2)
            await pool.step([4, 4])
            os.kill(server.process_id, signal.SIGTERM)
            with pytest.raises(errors.UnavailableError, match="drains"):
                while True:
                    await pool.step([4, 4])

    with ServerProcess(flags=["--workers=1", "--drain_timeout=1s"]) as server:
        asyncio.run(play(server))


def test_other_streams_are_ended_only_by_take_over(server: ServerProcess, client: Client) -> None:
    async def play(other: aio.AsyncClient) -> None:
        with client.create_pool("maze", 2) as pool:
            pool.step([4, 4])
            twin = await other.get_pool(pool.name)
            with pytest.raises(errors.FailedPreconditionError, match="attached"):
                await twin.step([4, 4])
            await twin.attach(take_over=True)
            await twin.step([4, 4])
            with pytest.raises(errors.AbortedError, match="took over"):
                pool.step([4, 4])
            await twin.close()
            with pytest.raises(errors.FailedPreconditionError, match="send first"):
                await twin.receive()

    _run(server, play)
