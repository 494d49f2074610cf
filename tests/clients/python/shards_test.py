"""Pools that are spread over several servers, which come and go."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pytest
from conftest import assert_same, server_binary

from procgen_client import Batch, Client, LevelSampler, Pool, Reset, ServerProcess, errors

_GAMES = ["maze", "bigfish"]
_ENV_COUNT = 25 * len(_GAMES)
_OPTIONS = {"distribution_mode": "easy", "rand_seed": 5}
_STILL = [4] * _ENV_COUNT
_ACTIONS = np.random.default_rng(3).integers(-1, 15, (60, _ENV_COUNT))


@contextmanager
def _three_servers() -> Iterator[list[ServerProcess]]:
    with ExitStack() as stack:
        yield [
            stack.enter_context(ServerProcess(server_binary(), ["--workers=1"])) for _ in range(3)
        ]


@pytest.fixture(name="servers", scope="module")
def _servers() -> Iterator[list[ServerProcess]]:
    """Servers of all tests that stop none."""
    with _three_servers() as servers:
        yield servers


@pytest.fixture(name="own_servers")
def _own_servers() -> Iterator[list[ServerProcess]]:
    """Servers that the test may stop."""
    with _three_servers() as servers:
        yield servers


def _addresses(servers: list[ServerProcess]) -> str:
    return ",".join(server.address for server in servers)


def _pool_counts(servers: list[ServerProcess]) -> list[int]:
    counts = []
    for server in servers:
        with Client(server.address) as client:
            counts.append(sum(pool.spec.env_count for pool in client.list_pools()))
    return counts


def _pool_names(servers: list[ServerProcess]) -> list[list[str]]:
    names = []
    for server in servers:
        with Client(server.address) as client:
            names.append([pool.name for pool in client.list_pools()])
    return names


def _played(pool: Pool) -> list[Batch]:
    """Uses all that a pool can do, also across the borders of slices."""
    trace = [pool.observe()]
    trace += [pool.step(actions, final_observations=True) for actions in _ACTIONS[:20]]
    for i in range(9):
        pool.send_step(_ACTIONS[i, 5:40], first_env=5, env_count=35)
    trace += [pool.receive() for _ in range(9)]
    states = pool.save_states([1, 30, 49])
    pool.step(_ACTIONS[0])
    pool.restore_states({1: states[0], 30: states[1], 49: states[2]})
    pool.clone_states([(0, 48), (48, 0), (2, 26)])
    pool.set_level_sampler(LevelSampler([3, 4, 5], [1, 2, 3], rand_seed=7))
    trace += [pool.reset([Reset(0, level_seed=1), 24, Reset(49, level_seed=3)])]
    trace += [pool.step(actions, repeat_count=3) for actions in _ACTIONS[20:]]
    return trace


@pytest.mark.parametrize("options", [{}, {"frame_stack": 3, "autoreset_mode": "next_step"}])
def test_results_equal_those_of_a_pool_in_this_process(
    servers: list[ServerProcess], options: dict[str, object]
) -> None:
    with Pool(_GAMES, _ENV_COUNT, **_OPTIONS, **options) as pool:
        expected = _played(pool)
        view = pool.render([40], size_px=64)[0]
    address = _addresses(servers)
    with Pool(_GAMES, _ENV_COUNT, server=address, **_OPTIONS, **options) as pool:
        assert _pool_counts(servers) == [17, 17, 16]
        for one, other in zip(expected, _played(pool), strict=True):
            assert_same(one, other)
        np.testing.assert_array_equal(view, pool.render([40], size_px=64)[0])
    assert _pool_counts(servers) == [0, 0, 0]


@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGTERM, signal.SIGSTOP])
def test_the_slice_of_a_lost_server_continues_on_another(
    own_servers: list[ServerProcess], end: signal.Signals
) -> None:
    with Pool(_GAMES, _ENV_COUNT, **_OPTIONS) as pool:
        expected = [pool.step(actions) for actions in _ACTIONS]
    longest = 0.0
    with Pool(_GAMES, _ENV_COUNT, server=_addresses(own_servers), **_OPTIONS) as pool:
        for i, actions in enumerate(_ACTIONS):
            if i == 30:
                os.kill(own_servers[1].process_id, end)
            begin = time.monotonic()
            assert_same(expected[i], pool.step(actions))
            longest = max(longest, time.monotonic() - begin)
        assert longest < 10
        assert sum(_pool_counts([own_servers[0], own_servers[2]])) == _ENV_COUNT
        if end == signal.SIGSTOP:
            os.kill(own_servers[1].process_id, signal.SIGCONT)


def _step_until(pool: Pool, expected: Iterator[Batch], condition: Callable[[], bool]) -> None:
    """Steps the pool, whose batches must be the expected ones, until the condition holds."""
    deadline = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < deadline
        for _ in range(20):
            assert_same(next(expected), pool.step(_STILL))


def _await_members(server: ServerProcess, count: int) -> None:
    with Client(server.address) as client:
        while len(client.list_nodes().nodes) != count:
            time.sleep(0.05)


def _expected() -> Iterator[Batch]:
    with Pool(_GAMES, _ENV_COUNT, **_OPTIONS) as pool:
        while True:
            yield pool.step(_STILL)


def test_a_slice_returns_to_its_server(own_servers: list[ServerProcess]) -> None:
    expected = _expected()
    address = own_servers[1].address
    with Pool(_GAMES, _ENV_COUNT, server=_addresses(own_servers), **_OPTIONS) as pool:
        own_servers[1].stop()
        others = [own_servers[0], own_servers[2]]
        _step_until(pool, expected, lambda: sum(_pool_counts(others)) == 50)
        with ServerProcess(server_binary(), ["--workers=1"], address=address) as again:
            _step_until(pool, expected, lambda: _pool_counts([again]) == [17])


def _cluster_flags(node_id: str) -> list[str]:
    return [
        f"--cluster=shards-{os.getpid()}",
        f"--cluster_domain={os.getpid() % 200}",
        f"--node_id={node_id}",
        "--workers=1",
    ]


def test_the_members_of_a_cluster_share_a_pool_and_a_new_one_replaces_a_lost_one() -> None:
    expected = _expected()
    with ExitStack() as stack:
        a, b = (
            stack.enter_context(ServerProcess(server_binary(), _cluster_flags(each)))
            for each in "ab"
        )
        _await_members(a, 2)
        address = f"cluster:{a.address}"
        pool = stack.enter_context(Pool(_GAMES, _ENV_COUNT, server=address, **_OPTIONS))
        assert _pool_counts([a, b]) == [25, 25]
        c = stack.enter_context(ServerProcess(server_binary(), _cluster_flags("c")))
        _await_members(a, 3)
        # Both servers of the pool are lost, also the one whose address it was given.
        os.kill(b.process_id, signal.SIGKILL)
        _step_until(pool, expected, lambda: sum(_pool_counts([a, c])) == 50)
        os.kill(a.process_id, signal.SIGKILL)
        _step_until(pool, expected, lambda: _pool_counts([c]) == [50])


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can mount a file of host names")
def test_a_name_with_several_addresses_stands_for_several_servers(tmp_path: Path) -> None:
    flags = ["--workers=1", "--allow_insecure"]
    with ServerProcess(server_binary(), flags, address="127.0.0.2:0") as a:
        port = a.address.rsplit(":", 1)[1]
        with ServerProcess(server_binary(), flags, address=f"127.0.0.3:{port}") as b:
            hosts = tmp_path / "hosts"
            hosts.write_text("127.0.0.2 rollouts\n127.0.0.3 rollouts\n")
            program = f"""
from procgen_client import Client, Pool
with Pool("maze", 10, server="rollouts:{port}") as pool:
    pool.step([4] * 10)
    for server in ({a.address!r}, {b.address!r}):
        with Client(server) as client:
            print([each.spec.env_count for each in client.list_pools()])
"""
            command = f'mount --bind "{hosts}" /etc/hosts && exec "{sys.executable}" -c "$PROGRAM"'
            ended = subprocess.run(
                ["unshare", "--mount", "sh", "-c", command],
                env=os.environ | {"PROGRAM": program},
                capture_output=True,
                text=True,
                check=False,
            )
    if "unshare failed" in ended.stderr:
        pytest.skip(ended.stderr)
    assert (ended.stdout, ended.stderr) == ("[5]\n[5]\n", "")


def test_a_server_that_does_not_answer_gets_no_slice(servers: list[ServerProcess]) -> None:
    address = f"127.0.0.1:1,{_addresses(servers[:2])}"
    with Pool(_GAMES, _ENV_COUNT, server=address, **_OPTIONS) as pool:
        assert _pool_counts(servers) == [25, 25, 0]
        pool.step(_ACTIONS[0])
    with pytest.raises(errors.UnavailableError):
        Client("127.0.0.1:1,127.0.0.1:2", timeout=0.3)


def test_a_pool_of_fewer_environments_than_servers_uses_some(servers: list[ServerProcess]) -> None:
    with Pool("maze", 2, server=_addresses(servers), **_OPTIONS) as pool:
        assert sorted(_pool_counts(servers)) == [0, 1, 1]
        pool.step([4, 4])


def test_a_learner_that_computes_for_seconds_keeps_its_connections(
    servers: list[ServerProcess],
) -> None:
    with Pool(_GAMES, _ENV_COUNT, server=_addresses(servers), **_OPTIONS) as pool:
        names = _pool_names(servers)
        pool.step(_ACTIONS[0])
        time.sleep(2.5)  # Longer than the silence after which a server is given up.
        pool.step(_ACTIONS[1])
        assert _pool_names(servers) == names


def test_errors_name_the_slice_that_counts_the_environments(servers: list[ServerProcess]) -> None:
    with Pool(_GAMES, _ENV_COUNT, server=_addresses(servers), **_OPTIONS) as pool:
        state = pool.save_states([20])[0]
        with pytest.raises(errors.DataLossError, match="begins with environment 17: environment 3"):
            pool.restore_states({20: state[:-1]})
        pool.restore_states({20: state})
