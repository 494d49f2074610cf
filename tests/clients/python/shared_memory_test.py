"""Pools in shared memory: views without a copy, and no leaks after any process is killed."""

from __future__ import annotations

import gc
import os
import resource
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from conftest import native_only, server_binary
from fault_proxy import Proxy, connected

from procgen_client import Batch, Client, Pool, ProcgenVectorEnv, ServerProcess, errors

pytestmark = native_only

_ENV_COUNT = 4
_OPTIONS = {"distribution_mode": "easy", "rand_seed": 5}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The server's shared memory folder, which must be empty at the end."""
    path = tmp_path / "shared"
    path.mkdir()
    return path


@pytest.fixture
def server(folder: Path) -> Iterator[ServerProcess]:
    """A server of this test."""
    with ServerProcess(
        server_binary(), ["--workers=2", f"--shared_memory_dir={folder}"]
    ) as process:
        yield process
        process.stop()
    assert not list(folder.iterdir())


def _create(client: Client, *, env_count: int = _ENV_COUNT, **arguments: object) -> Pool:
    return client.create_pool(
        ["maze", "bigfish"],
        env_count,
        transport="shared_memory",
        copy=False,
        **_OPTIONS,
        **arguments,
    )


def _actions(step: int, count: int = _ENV_COUNT) -> list[int]:
    return [(step // 3 * 7 + i * 5) % 16 - 1 for i in range(count)]


def _assert_equal(left: Batch, right: Batch) -> None:
    for name in Batch.__dataclass_fields__:
        a, b = getattr(left, name), getattr(right, name)
        if isinstance(a, np.ndarray):
            assert a.dtype == b.dtype, name
        np.testing.assert_array_equal(a, b, name)


def _mappings(folder: Path) -> int:
    """The number of mappings of files in the folder in this process."""
    return Path("/proc/self/maps").read_text().count(str(folder))


def test_batches_equal_those_of_the_stream(client: Client) -> None:
    with (
        client.create_pool(["maze", "bigfish"], _ENV_COUNT, **_OPTIONS) as stream,
        _create(client) as shared,
    ):
        assert shared.spec.transport == 2
        _assert_equal(stream.observe(), shared.observe())
        for step in range(120):
            arguments = {
                "final_observations": step % 2 == 0,
                "observe": step % 5 != 4,
                "repeat_count": 1 + step % 3,
                "resets": [1] if step % 11 == 0 else [],
            }
            if step % 3 == 2:
                arguments |= {"first_env": 1, "env_count": 2}
            actions = _actions(step, 2 if step % 3 == 2 else _ENV_COUNT)
            _assert_equal(stream.step(actions, **arguments), shared.step(actions, **arguments))


def test_observations_are_read_only_views_and_other_arrays_are_copies(
    client: Client, folder: Path
) -> None:
    with _create(client) as pool:
        batch = pool.step([4] * _ENV_COUNT, final_observations=True)
        assert batch.observations is not None
        assert not batch.observations.flags.writeable
        assert not batch.observations.flags.owndata
        with pytest.raises(ValueError, match="read-only"):
            batch.observations[0] = 0
        batch.rewards[0] = 1  # A copy.
        observations = batch.observations
        content = observations.copy()
        del batch
        for step in range(20):
            pool.step(_actions(step))
        np.testing.assert_array_equal(observations, content)
        (file,) = folder.iterdir()
        assert file.read_bytes().find(content.tobytes()) >= 0
        assert file.stat().st_mode & 0o777 == 0o600


def test_batches_are_released_when_no_array_refers_to_them(client: Client) -> None:
    with _create(client, held_batches_max=3) as pool:
        kept = [pool.step([4] * _ENV_COUNT).observations[1:, ::2] for _ in range(5)]
        with pytest.raises(errors.FailedPreconditionError, match="refer to 5 batches .* of 5 bat"):
            pool.step([4] * _ENV_COUNT)
        assert pool.attached, "nothing was sent"
        kept[2] = None
        pool.step([4] * _ENV_COUNT)
        numbers = [pool.step([4] * _ENV_COUNT).rewards for _ in range(20)]
        assert len(numbers) == 20
        kept.clear()
        cycle = [pool.observe().observations for _ in range(5)]
        cycle.append(cycle)
        del cycle
        gc.disable()
        try:
            pool.step([4] * _ENV_COUNT)  # The client runs the garbage collector.
        finally:
            gc.enable()


def test_pipelined_requests_return_equal_batches(client: Client) -> None:
    with (
        client.create_pool(
            ["maze", "bigfish"], _ENV_COUNT, requests_in_flight_max=4, **_OPTIONS
        ) as stream,
        _create(client, requests_in_flight_max=4) as shared,
    ):
        batches = []
        for pool in (stream, shared):
            for step in range(4):
                pool.send_step(_actions(step))
            batches.append([pool.receive() for _ in range(4)])
        for left, right in zip(*batches, strict=True):
            _assert_equal(left, right)


def test_vector_environments_return_views_or_copies(server: ServerProcess) -> None:
    for copy in (True, False):
        with (
            ProcgenVectorEnv("maze", 2, server=server.address, copy=copy, **_OPTIONS) as stream,
            ProcgenVectorEnv(
                "maze", 2, server=server.address, copy=copy, transport="shared_memory", **_OPTIONS
            ) as shared,
        ):
            left, _ = stream.reset()
            right, _ = shared.reset()
            kept = []
            for step in range(60):
                np.testing.assert_array_equal(left, right)
                assert right.flags.owndata is copy
                left, *left_rest = stream.step(_actions(step, 2))
                right, *right_rest = shared.step(_actions(step, 2))
                np.testing.assert_array_equal(left_rest[0], right_rest[0])
                kept.append(right if copy else right_rest[0])


def test_arrays_outlive_pool_client_and_server(folder: Path) -> None:
    with ServerProcess(server_binary(), [f"--shared_memory_dir={folder}"]) as server:
        with Client(server.address) as client, _create(client) as pool:
            observations = pool.observe().observations
            content = observations.copy()
    assert not list(folder.iterdir())
    np.testing.assert_array_equal(observations, content)
    assert _mappings(folder) == 1
    del observations, pool
    gc.collect()
    assert _mappings(folder) == 0


def test_thousand_attaches_leave_no_files_or_mappings(client: Client, folder: Path) -> None:
    before = len(os.listdir("/proc/self/fd"))
    with _create(client, env_count=2) as pool:
        for _ in range(1000):
            pool.attach()
            pool.detach()
        batch = pool.observe()
        assert len(list(folder.iterdir())) == 1
        assert _mappings(folder) == 1
        del batch
    for _ in range(10):
        with _create(client, env_count=2) as pool:
            pool.observe()
    del pool
    gc.collect()
    while list(folder.iterdir()):  # A deleted pool is freed a little later.
        pass
    assert _mappings(folder) == 0
    assert len(os.listdir("/proc/self/fd")) <= before + 2


def test_held_batches_survive_detach_and_reattach(server: ServerProcess) -> None:
    for reconnect_timeout in (0, 60):
        with (
            Client(server.address, reconnect_timeout=reconnect_timeout) as client,
            _create(client) as pool,
        ):
            held = pool.observe().observations
            content = held.copy()
            pool.detach()
            for step in range(10):
                pool.step(_actions(step))
            with pytest.raises(errors.InvalidArgumentError):
                pool.step([4] * _ENV_COUNT, next_levels={99: 1})  # Ends the stream.
            assert not pool.attached
            for step in range(10):
                pool.step(_actions(step))
            np.testing.assert_array_equal(held, content)


def test_held_batches_survive_a_faulty_network(server: ServerProcess, client: Client) -> None:
    # Messages bypass the network through pipes, which end with the connection.
    proxy = Proxy(server.address, 7, 3000, silence_max_ms=10)
    with client.create_pool(["maze", "bigfish"], _ENV_COUNT, **_OPTIONS) as reference:
        with _create(client) as pool, connected(proxy.address) as learner:
            other = None
            while other is None or not other.attached:  # The client retries streams only.
                try:
                    other = learner.get_pool(pool.name, held_batches_max=4)
                    other.attach(take_over=True)
                except errors.ProcgenError:
                    pass
            held = []
            for step in range(500):
                batch = other.step(_actions(step))
                _assert_equal(reference.step(_actions(step)), batch)
                held.append((batch.observations, batch.observations.copy()))
                if len(held) > 4:
                    observations, content = held.pop(step % 4)
                    np.testing.assert_array_equal(observations, content)
                del batch
    assert proxy.stop() >= 10


def test_errors_end_the_stream_and_its_pipes(client: Client) -> None:
    with _create(client) as pool:
        pool.step([4] * _ENV_COUNT)
        with pytest.raises(errors.InvalidArgumentError, match="next_levels"):
            pool.step([4] * _ENV_COUNT, next_levels={99: 1})
        pool.step([4] * _ENV_COUNT)


def test_takeover_makes_all_batches_available(client: Client) -> None:
    with _create(client) as pool:
        held = [pool.observe().observations for _ in range(3)]
        with client.get_pool(pool.name) as other:
            other.attach(take_over=True)
            mine = [other.step([4] * _ENV_COUNT).observations for _ in range(4)]
            assert len(mine) == 4
        with pytest.raises(errors.AbortedError, match="took over"):
            pool.step([4] * _ENV_COUNT)
        del held


def test_next_server_removes_files_of_killed_servers(folder: Path) -> None:
    flags = [f"--shared_memory_dir={folder}"]
    with ServerProcess(server_binary(), flags) as living:
        with Client(living.address) as client, _create(client) as pool:
            pool.observe()
            (kept,) = folder.iterdir()
            with ServerProcess(server_binary(), flags) as killed:
                with Client(killed.address, reconnect_timeout=0) as its_client:
                    its_pool = _create(its_client)
                    observations = its_pool.observe().observations
                    content = observations.copy()
                    os.kill(killed.process_id, signal.SIGKILL)
                    with pytest.raises(errors.UnavailableError):
                        while True:
                            its_pool.step([4] * _ENV_COUNT)
            assert len(list(folder.iterdir())) == 2
            with ServerProcess(server_binary(), flags):
                assert list(folder.iterdir()) == [kept], "the file of the running server"
            np.testing.assert_array_equal(observations, content)
            pool.step([4] * _ENV_COUNT)


def test_killed_learner_holds_no_batches_and_leaves_no_files(
    server: ServerProcess, client: Client, folder: Path
) -> None:
    learner = f"""
import procgen_client
client = procgen_client.connect("{server.address}")
pool = client.get_pool("pools/of-the-killed", copy=False)
held = [pool.observe().observations for _ in range(4)]
print("holds", flush=True)
import time
time.sleep(600)
"""
    with _create(client, pool_id="of-the-killed") as pool:
        process = subprocess.Popen(
            [sys.executable, "-c", learner], stdout=subprocess.PIPE, text=True
        )
        assert process.stdout is not None
        assert process.stdout.readline() == "holds\n"
        process.kill()
        process.wait()
        process.stdout.close()
        pool.attach(take_over=True)
        held = [pool.step([4] * _ENV_COUNT).observations for _ in range(4)]
        assert len(held) == 4
        assert len(list(folder.iterdir())) == 1


def test_full_disk_error_names_path_and_size(folder: Path) -> None:
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 20, limit[1]))
    try:
        server = ServerProcess(server_binary(), [f"--shared_memory_dir={folder}"])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limit)
    with server, Client(server.address) as client, _create(client, env_count=64) as pool:
        with pytest.raises(errors.ResourceExhaustedError, match=rf"\d+ bytes in {folder}/procgen-"):
            pool.observe()
        assert not list(folder.iterdir())
        with _create(client, env_count=2) as small:
            small.observe()


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can change its user id")
def test_error_for_other_users_names_the_stream_transport(
    server: ServerProcess, client: Client
) -> None:
    learner = f"""
import os
from procgen_client import connect, errors
os.setuid(65534)
pool = connect("{server.address}").get_pool("pools/of-others")
try:
    pool.observe()
except errors.FailedPreconditionError as error:
    print(error.message)
"""
    with _create(client, pool_id="of-others"):
        said = subprocess.run(
            [sys.executable, "-c", learner], capture_output=True, text=True, check=False
        )
    assert "Permission denied" in said.stdout, said.stderr
    assert "TRANSPORT_STREAM" in said.stdout


def test_invalid_shared_memory_dirs_are_rejected(tmp_path: Path) -> None:
    with pytest.raises(errors.UnavailableError):
        ServerProcess(server_binary(), [f"--shared_memory_dir={tmp_path}/none"])
    with ServerProcess(server_binary(), ["--shared_memory_dir="]) as server:
        with Client(server.address) as client:
            with pytest.raises(errors.UnimplementedError, match="offered: TRANSPORT_STREAM"):
                _create(client)


def test_unknown_transport_error_lists_the_names(client: Client) -> None:
    with pytest.raises(errors.InvalidArgumentError, match="stream, shared_memory"):
        client.create_pool("maze", 1, transport="pigeon")


def test_shared_memory_rejects_encodings(client: Client) -> None:
    with pytest.raises(errors.InvalidArgumentError, match="SHARED_MEMORY: ENCODING_RAW"):
        _create(client, encoding="delta_zstd")
