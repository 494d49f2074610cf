"""`reopen` of a vector environment: it continues after its pool was lost."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import numpy as np
import pytest
from conftest import server_binary

from procgen_client import Client, ProcgenVectorEnv, ServerProcess, errors

_N = 4
_LOST = (errors.NotFoundError, errors.UnavailableError)


def _lose(server: ServerProcess, address: str) -> None:
    os.kill(server.process_id, signal.SIGKILL)
    Path(address.removeprefix("unix:")).unlink(missing_ok=True)


def _played(env: ProcgenVectorEnv) -> list[np.ndarray]:
    """The observations of 20 steps, in which episodes end."""
    return [env.step(np.where(np.arange(_N) == t % 5, -1, 7))[0].copy() for t in range(20)]


def _step_until_lost(env: ProcgenVectorEnv) -> None:
    with pytest.raises(_LOST):
        while True:
            env.step([7] * _N)


def test_reopened_environment_continues_from_its_checkpoint(tmp_path: Path) -> None:
    address, path = f"unix:{tmp_path}/socket", tmp_path / "checkpoint"
    with ServerProcess(server_binary(), address=address) as lost:
        client = Client(address, reconnect_timeout=0)
        env = ProcgenVectorEnv("coinrun", _N, server=client, rand_seed=1)
        env.reset()
        _played(env)
        env.save(path)
        expected = _played(env)
        _lose(lost, address)
    with ServerProcess(server_binary(), address=address), Client(address) as other:
        _step_until_lost(env)
        namesake = other.create_pool("maze", 2)
        assert namesake.name == env.pool.name
        env.reopen(path)
        np.testing.assert_array_equal(_played(env), expected)
        assert sorted(pool.name for pool in other.list_pools()) == sorted(
            [namesake.name, env.pool.name]
        )
        env.close()
        assert [pool.name for pool in other.list_pools()] == [namesake.name]
        client.close()


def test_reopened_environment_without_a_checkpoint_is_new(tmp_path: Path) -> None:
    address = f"unix:{tmp_path}/socket"
    with ServerProcess(server_binary(), address=address) as lost:
        client = Client(address, reconnect_timeout=0)
        env = ProcgenVectorEnv("coinrun", _N, server=client, rand_seed=1)
        first, _ = env.reset()
        first = first.copy()
        _played(env)
        _lose(lost, address)
    with ServerProcess(server_binary(), address=address):
        _step_until_lost(env)
        observations, infos = env.reopen()
        np.testing.assert_array_equal(observations, first)
        assert infos["_level_seed"].all()
        env.close()
        client.close()
