"""Reconnecting streams, and leases of pools."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
import zlib

import numpy as np
import pytest
from conftest import native_only, server_binary
from fault_proxy import Proxy, connected

from procgen_client import Batch, Client, Pool, ServerProcess, errors

_ENV_COUNT = 12
_HALF = _ENV_COUNT // 2
_OPTIONS = {"distribution_mode": "easy", "rand_seed": 5, "transport": "stream"}


def _attach(pool: Pool) -> None:
    """Repeats attach, which the client does not retry: it could end another learner's stream."""
    while not pool.attached:
        try:
            pool.attach(take_over=True, response_bytes_max=65536)
        except errors.ProcgenError:
            pass


def _fingerprint(batch: Batch) -> int:
    crc = 0
    for array in (
        batch.observations,
        batch.rewards,
        batch.first,
        batch.terminated,
        batch.truncated,
        batch.level_seeds,
        batch.prev_level_seeds,
        batch.prev_level_complete,
        batch.episode_returns,
        batch.episode_lengths,
        batch.fingerprints,
    ):
        crc = zlib.crc32(np.ascontiguousarray(array).tobytes(), crc)
    return crc


def _trace(pool: Pool, count: int) -> list[int]:
    """Steps the two halves of the pool in turn, with pipelined requests."""
    rng = np.random.default_rng(3)
    actions = rng.integers(-1, 15, (count, _HALF))
    _attach(pool)
    trace: list[int] = []
    sent = 0
    while len(trace) < count:
        while sent < count and pool.in_flight < pool.requests_in_flight_max:
            pool.send_step(actions[sent], first_env=sent % 2 * _HALF, env_count=_HALF)
            sent += 1
        trace.append(_fingerprint(pool.receive()))
    return trace


@native_only
@pytest.mark.parametrize(
    "encoding,count,bytes_between_faults,least_break_count",
    [
        ("raw", 150, 120_000, 30),
        ("delta_zstd", 300, 40_000, 5),
    ],
)
def test_faulty_network_loses_nothing(
    server: ServerProcess,
    client: Client,
    encoding: str,
    count: int,
    bytes_between_faults: int,
    least_break_count: int,
) -> None:
    with client.create_pool(["maze", "bigfish"], _ENV_COUNT, **_OPTIONS) as pool:
        expected = _trace(pool, count)
    proxy = Proxy(server.address, 11, bytes_between_faults)
    with client.create_pool(
        ["maze", "bigfish"], _ENV_COUNT, encoding=encoding, **_OPTIONS
    ) as pool:
        with connected(proxy.address) as learner:
            actual = _trace(
                learner.get_pool(pool.name, requests_in_flight_max=3), count
            )
        assert client.get_pool(pool.name) is not None
    assert proxy.stop() >= least_break_count
    assert actual == expected


@native_only
def test_reconnecting_to_a_lost_server_times_out() -> None:
    with ServerProcess(flags=["--workers=1"]) as server:
        with Client(server.address, reconnect_timeout=0.5) as client:
            pool = client.create_pool("maze", 2)
            pool.step([4, 4])
            os.kill(server.process_id, signal.SIGKILL)
            begin = time.monotonic()
            with pytest.raises(errors.UnavailableError, match="made again within (500ms|0.5 s)"):
                while True:
                    pool.step([4, 4])
            assert time.monotonic() - begin < 10
            assert not pool.attached


def test_without_reconnect_timeout_the_first_loss_is_an_error() -> None:
    with ServerProcess(flags=["--workers=1"]) as server:
        with Client(server.address, reconnect_timeout=0) as client:
            pool = client.create_pool("maze", 2)
            pool.step([4, 4])
            os.kill(server.process_id, signal.SIGKILL)
            with pytest.raises(errors.UnavailableError) as caught:
                while True:
                    pool.step([4, 4])
            assert "made again" not in caught.value.message


def test_draining_server_is_not_contacted_again() -> None:
    with ServerProcess(flags=["--workers=1", "--drain_timeout=1s"]) as server:
        with Client(server.address, reconnect_timeout=600) as client:
            pool = client.create_pool("maze", 2)
            pool.step([4, 4])
            os.kill(server.process_id, signal.SIGTERM)
            with pytest.raises(errors.UnavailableError, match="drains"):
                while True:
                    pool.step([4, 4])


def test_step_after_a_takeover_is_aborted(client: Client) -> None:
    with client.create_pool("maze", 2) as pool:
        pool.step([4, 4])
        with client.get_pool(pool.name) as other:
            other.attach(take_over=True)
            other.step([4, 4])
        with pytest.raises(errors.AbortedError, match="took over"):
            pool.step([4, 4])


def test_lease_is_returned_and_renewed(client: Client) -> None:
    with client.create_pool("maze", 1, lease_duration=90.5) as pool:
        assert pool.spec.lease_duration.ToTimedelta().total_seconds() == 90.5
        pool.renew()
        pool.renew(3600)
        message = next(message for message in client.list_pools() if message.name == pool.name)
        assert message.spec.lease_duration.seconds == 3600
        with pytest.raises(errors.InvalidArgumentError, match="lease_duration is 500ms"):
            pool.renew(0.5)
        with pytest.raises(errors.ResourceExhaustedError, match="lease_duration_max is 24h"):
            pool.renew(25 * 3600)


@pytest.mark.parametrize(
    ("flag", "argument"),
    [("--lease_duration_default=1s", ""), ("--lease_duration_default=0s", ", lease_duration=1")],
    ids=["default", "given"],
)
def test_pool_of_a_killed_learner_is_deleted_when_its_lease_expires(
    flag: str, argument: str
) -> None:
    learner = f"""
import sys, procgen_client
client = procgen_client.connect(sys.argv[1])
pool = client.create_pool("maze", 1, pool_id="of-the-killed"{argument})
pool.observe()
print("attached", flush=True)
while True:
    pool.step([4])
"""
    with ServerProcess(server_binary(), [flag]) as server, Client(server.address) as client:
        process = subprocess.Popen(
            [sys.executable, "-c", learner, server.address], stdout=subprocess.PIPE, text=True
        )
        assert process.stdout is not None
        assert process.stdout.readline() == "attached\n"
        assert client.get_pool("pools/of-the-killed") is not None
        process.kill()
        process.wait()
        process.stdout.close()
        with pytest.raises(errors.NotFoundError):
            while True:  # Until the lease of one second expires.
                client.get_pool("pools/of-the-killed")
