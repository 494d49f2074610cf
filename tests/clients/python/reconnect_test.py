"""Broken connections: pools resume; lost and draining servers; pools of killed programs."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import assert_same, server_binary

from procgen_client import Client, Pool, ServerProcess, errors

_ENV_COUNT = 12
_GAMES = ["maze", "bigfish"]
_OPTIONS = {"distribution_mode": "easy", "rand_seed": 5}


@pytest.mark.parametrize(
    ("reconnect_timeout", "words"),
    [
        (0.5, "made again within (500ms|0.5 s)"),
        (0, "^(?!.*made again)"),
    ],
)
def test_steps_on_a_lost_server_fail(reconnect_timeout: float, words: str) -> None:
    with ServerProcess(flags=["--workers=1"]) as server:
        with Client(server.address, reconnect_timeout=reconnect_timeout) as client:
            pool = client.create_pool("maze", 2)
            pool.step([4, 4])
            os.kill(server.process_id, signal.SIGKILL)
            begin = time.monotonic()
            with pytest.raises(errors.UnavailableError, match=words):
                while True:
                    pool.step([4, 4])
            assert time.monotonic() - begin < 10
            with pytest.raises((errors.UnavailableError, errors.NotFoundError)):
                pool.step([4, 4])
            pool.close()


@pytest.mark.parametrize(
    ("stop", "games", "variant"),
    [
        (signal.SIGKILL, _GAMES, None),
        (signal.SIGTERM, _GAMES, None),
        (signal.SIGKILL, "coinrun", "coin_random"),
    ],
)
def test_pools_survive_the_end_of_their_server(
    tmp_path: Path, stop: signal.Signals, games: str | list[str], variant: str | None
) -> None:
    address = f"unix:{tmp_path}/socket"
    options = {**_OPTIONS, "variant": variant}
    actions = np.random.default_rng(3).integers(-1, 15, (60, _ENV_COUNT))
    with Pool(games, _ENV_COUNT, **options) as pool:
        expected = [pool.step(each) for each in actions]
    server = ServerProcess(server_binary(), address=address)
    with Client(address) as client, client.create_pool(games, _ENV_COUNT, **options) as pool:
        for i, (action, batch) in enumerate(zip(actions, expected, strict=True)):
            assert_same(batch, pool.step(action))
            if i % 20 == 10:
                os.kill(server.process_id, stop)
                server.stop()
                (tmp_path / "socket").unlink(missing_ok=True)
                server = ServerProcess(server_binary(), address=address)
    server.stop()


def test_a_draining_server_is_named_if_none_takes_its_place() -> None:
    with ServerProcess(flags=["--workers=1"]) as server:
        with Client(server.address, reconnect_timeout=1) as client:
            pool = client.create_pool("maze", 2)
            pool.step([4, 4])
            os.kill(server.process_id, signal.SIGTERM)
            with pytest.raises(errors.UnavailableError, match="made again within 1s"):
                while True:
                    pool.step([4, 4])


@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGSTOP])
def test_pool_of_a_lost_program_is_freed(end: signal.Signals) -> None:
    learner = """
import sys, procgen_client
pool = procgen_client.Pool("maze", 1, server=sys.argv[1], pool_id="of-the-lost")
pool.observe()
print("made", flush=True)
while True:
    pool.step([4])
"""
    # A stopped program's connection stays open, but it does not answer pings.
    flags = ["--keepalive_time=500ms", "--keepalive_timeout=3s"]
    with ServerProcess(server_binary(), flags) as server, Client(server.address) as client:
        process = subprocess.Popen(
            [sys.executable, "-c", learner, server.address], stdout=subprocess.PIPE
        )
        try:
            assert process.stdout.readline() == b"made\n"
            assert client.get_pool("pools/of-the-lost").spec.env_count == 1
            process.send_signal(end)
            with pytest.raises(errors.NotFoundError):
                while True:  # Until the server notices.
                    client.get_pool("pools/of-the-lost")
        finally:
            process.kill()
            process.communicate()
