"""Connections: closing, interrupted waits, unix sockets, large messages."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import numpy as np
import pytest
from conftest import server_binary

from procgen_client import Client, Pool, Reset, ServerProcess, connect, errors

# A single wait may end later on a busy machine.
_INTERRUPTED_WITHIN = 1.0
_FASTEST_INTERRUPTED_WITHIN = 0.15  # The library looks at signals every 0.05 s.


def test_closing_the_client_ends_the_steps_of_its_pools(
    server: ServerProcess, client: Client
) -> None:
    closed = Client(server.address)
    pool = closed.create_pool("maze", 2)
    pool.step([4, 4])
    closed.close()
    for _ in range(2):
        with pytest.raises(errors.CancelledError):
            pool.step([4, 4])
    pool.close()
    with client.create_pool("maze", 2) as other:
        assert other.step([4, 4]).env_count == 2, "other connections continue"


def test_requests_beyond_the_first_window_are_sent_whole(client: Client) -> None:
    count = 4096
    with client.create_pool("bigfish", count) as pool:
        resets = [Reset(i, level_seed=2**30 + i, rand_seed=2**31 + i) for i in range(count)]
        batch = pool.reset(resets, observe=False)  # Larger than the server's initial window.
        assert batch.level_seeds.tolist() == list(range(2**30, 2**30 + count))


@contextmanager
def stopped(server: ServerProcess) -> Iterator[None]:
    """Stops the server process (SIGSTOP) during the block."""
    os.kill(server.process_id, signal.SIGSTOP)
    os.waitpid(server.process_id, os.WUNTRACED)  # Until all threads have stopped.
    try:
        yield
    finally:
        os.kill(server.process_id, signal.SIGCONT)


def assert_interrupted(wait: Callable[[], object]) -> float:
    """Expects that Ctrl-C ends `wait`, which would not end otherwise. Returns after how long."""
    sent: list[float] = []

    def interrupt() -> None:
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.3, interrupt)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        wait()
    duration = time.monotonic() - sent[0]
    assert duration < _INTERRUPTED_WITHIN
    timer.join()
    return duration


@pytest.fixture
def own() -> Iterator[ServerProcess]:
    """A server of this test, which it can stop."""
    with ServerProcess(server_binary(), ["--workers=1"]) as process:
        yield process


def test_wait_for_a_response_can_be_interrupted(own: ServerProcess) -> None:
    with Client(own.address) as client, client.create_pool("maze", 2) as pool:
        pool.step([4, 4])
        with stopped(own):
            pool.send_step([4, 4])
            assert_interrupted(pool.receive)
            assert pool.in_flight == 0
        assert pool.step([4, 4]).episode_lengths.tolist() == [3, 3], "the second step was taken"


def test_all_waits_can_be_interrupted(own: ServerProcess) -> None:
    with Client(own.address) as client, client.create_pool("maze", 2) as pool:
        watch = client.watch(pool)
        next(watch)
        with stopped(own):
            durations = [assert_interrupted(client.load) for _ in range(5)]
            assert min(durations) < _FASTEST_INTERRUPTED_WITHIN
            assert_interrupted(pool.save_states)
            assert_interrupted(lambda: client.create_pool("maze", 2))
            assert_interrupted(lambda: next(watch))
            assert_interrupted(lambda: connect(own.address, timeout=60))
        assert pool.step([4, 4]).env_count == 2


def test_pool_can_be_closed_while_an_interrupted_call_is_under_way(own: ServerProcess) -> None:
    pool = Pool("maze", 2, server=own.address)
    states = pool.save_states()
    with stopped(own):
        assert_interrupted(lambda: pool.restore_states(states))
        begin = time.monotonic()
        pool.close()
        assert time.monotonic() - begin < _INTERRUPTED_WITHIN
        with pytest.raises(errors.FailedPreconditionError, match="is closed"):
            pool.save_states()
        deadline = time.monotonic() + 20
        while "procgen-call" in [thread.name for thread in threading.enumerate()]:
            assert time.monotonic() < deadline, "the call does not end with the connection"
            time.sleep(0.05)
    with Client(own.address) as client:
        assert client.load() is not None


def test_closing_the_client_ends_waits_of_other_threads(own: ServerProcess) -> None:
    with Client(own.address) as client, ThreadPoolExecutor() as threads:
        pools = [client.create_pool("maze", 2) for _ in range(2)]
        watch = client.watch(pools[0])
        next(watch)
        with stopped(own):
            waits: list[Callable[[], object]] = [
                *(client.load, pools[1].save_states),
                *(lambda: next(watch), lambda: pools[0].step([4, 4])),
            ]
            running = [threads.submit(wait) for wait in waits]
            time.sleep(0.3)
            assert not any(each.done() for each in running)
            client.close()
            for each in running:
                assert isinstance(each.exception(20), errors.CancelledError)
        for pool in pools:
            pool.close()


def test_wait_for_a_lost_connection_can_be_interrupted(own: ServerProcess) -> None:
    with Client(own.address) as client:
        pool = client.create_pool("maze", 2)
        pool.step([4, 4])
        os.kill(own.process_id, signal.SIGKILL)

        def step_on() -> None:
            while True:
                pool.step([4, 4])

        assert_interrupted(step_on)


def test_memory_of_decoded_observations_is_reused(client: Client) -> None:
    def address_of(array: np.ndarray) -> int:
        return array.__array_interface__["data"][0]

    with client.create_pool("maze", 64, encoding="delta_zstd") as pool:
        kept = pool.step([4] * 64).observations
        content = kept.copy()
        addresses = {address_of(pool.step([4] * 64).observations) for _ in range(20)}
        assert len(addresses) < 5
        assert address_of(kept) not in addresses, "an array refers to it"
        np.testing.assert_array_equal(kept, content)
