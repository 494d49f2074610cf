"""transport="auto": shared memory where it is possible, the stream elsewhere, and the reason."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import native_only, server_binary

import procgen_client
from procgen_client import (
    Client,
    ProcgenEnv,
    ProcgenGym3Env,
    ProcgenGymEnv,
    ProcgenVectorEnv,
    ServerProcess,
    errors,
)
from procgen_client._transport import is_native
from procgen_client._transport.selection import is_own_address

_BEST = "shared_memory" if is_native() else "stream"


def test_pools_and_environments_choose_the_best_transport(
    server: ServerProcess, client: Client
) -> None:
    with client.create_pool("maze", 2) as pool:
        assert pool.transport == _BEST
        assert not pool.attached
        with client.get_pool(pool.name) as same:
            assert same.transport == _BEST
            assert same.transport_reason == "the pool was created with it"
    for env_type in (ProcgenVectorEnv, ProcgenGymEnv):
        env = env_type("maze", server=server.address)
        each = getattr(env, "vector_env", env)
        assert each.pool.transport == _BEST
        env.close()
    for args, env_class in (((2, "maze"), ProcgenGym3Env), ((2, "maze"), ProcgenEnv)):
        env = env_class(*args, server=server.address)
        assert getattr(env, "env", env).pool.transport == _BEST
        env.close()
        stream = env_class(*args, server=server.address, transport="stream")
        assert getattr(stream, "env", stream).pool.transport == "stream"
        stream.close()
    assert client.list_pools() == []


def test_reason_says_why_the_transport_was_chosen(client: Client) -> None:
    with client.create_pool("maze", 2, transport="stream") as pool:
        assert (pool.transport, pool.transport_reason) == ("stream", "the caller chose it")
    with client.create_pool("maze", 2) as pool:
        why = "this process maps the server's memory" if is_native() else "no native module"
        assert why in pool.transport_reason


def _run_without_the_native_module(
    program: str, folder: Path, *flags: str
) -> subprocess.CompletedProcess[str]:
    package = Path(procgen_client.__file__).parent
    ignored = shutil.ignore_patterns("_native*.so", "__pycache__")
    shutil.copytree(package, folder / "procgen_client", ignore=ignored)
    environment = {**os.environ, "PYTHONPATH": str(folder)}
    environment.pop("PROCGEN_CLIENT_NATIVE", None)
    environment.pop("PROCGEN_CLIENT_TRANSPORT", None)
    command = [sys.executable, *flags, "-c", program]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)


def test_connecting_without_the_native_module_warns_of_nothing(
    server: ServerProcess, tmp_path: Path
) -> None:
    program = f"import procgen_client; procgen_client.connect({server.address!r}).close()"
    run = _run_without_the_native_module(program, tmp_path, "-W", "error")
    assert run.returncode == 0, run.stderr


def test_slow_transport_for_want_of_the_native_module_is_warned_of_once(
    server: ServerProcess, tmp_path: Path
) -> None:
    program = f"""
import os, warnings
from procgen_client import Client, ProcgenVectorEnv
with Client({server.address!r}) as client, warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    client.create_pool("maze", 1, transport="stream").close()
    client.create_pool("maze", 1, pool_id="first").close()
    ProcgenVectorEnv("maze", 1, server=client).close()
    client.create_pool("maze", 1).close()
for each in caught:
    print(each.category.__name__, each.filename, each.lineno, each.message)
"""
    run = _run_without_the_native_module(program, tmp_path)
    assert run.returncode == 0, run.stderr
    (line,) = run.stdout.splitlines()
    assert line.startswith("RuntimeWarning <string> 7 the server is on this machine")
    assert "--target procgen-python-client" in line


@native_only
def test_encoded_pools_use_the_stream(client: Client) -> None:
    with client.create_pool("maze", 2, encoding="delta_zstd") as pool:
        assert pool.transport == "stream"
        assert "the observations are encoded" in pool.transport_reason


@native_only
def test_server_without_shared_memory_uses_the_stream() -> None:
    with ServerProcess(server_binary(), ["--shared_memory_dir="]) as server:
        with Client(server.address) as client, client.create_pool("maze", 2) as pool:
            assert pool.transport == "stream"
            assert "the server offers no shared memory" in pool.transport_reason
            assert pool.step([4, 4]).observations is not None


@native_only
def test_full_memory_leaves_the_stream(tmp_path: Path) -> None:
    flags = [f"--shared_memory_dir={tmp_path}", "--shared_memory_bytes_max=1000000"]
    with ServerProcess(server_binary(), flags) as server, Client(server.address) as client:
        with client.create_pool("maze", 64, pool_id="named") as pool:
            assert pool.name == "pools/named"
            assert pool.transport == "stream"
            assert "shared_memory_bytes_max" in pool.transport_reason
            assert len(client.list_pools()) == 1
            pool.step([4] * 64)
            with pytest.raises(errors.ResourceExhaustedError):
                client.create_pool("maze", 64, transport="shared_memory").observe()


@native_only
@pytest.mark.skipif(os.geteuid() != 0, reason="only root can change its user id")
def test_learner_of_another_user_uses_the_stream(server: ServerProcess) -> None:
    learner = f"""
import os
from procgen_client import ProcgenVectorEnv
os.setuid(65534)
env = ProcgenVectorEnv("maze", 2, server="{server.address}")
env.reset()
env.step([4, 4])
print(env.pool.transport, env.pool.transport_reason)
"""
    run = subprocess.run(
        [sys.executable, "-c", learner], capture_output=True, text=True, check=False
    )
    assert run.stdout.startswith("stream "), run.stderr
    assert "Permission denied" in run.stdout


def test_own_addresses_are_recognised() -> None:
    host = socket.gethostname()
    for own in ("localhost:1", "127.0.0.1:1", "[::1]:1", "unix:/x", "dns:///localhost:1"):
        assert is_own_address(own), own
    for own in (f"{host}:1", f"dns:///{host}:1"):
        assert is_own_address(own), own
    for other in ("192.0.2.1:1", "[2001:db8::1]:1", "no-such-host.invalid:1", "nonsense"):
        assert not is_own_address(other), other


@native_only
def test_arrays_of_auto_belong_to_the_caller_with_every_transport(client: Client) -> None:
    kept = []
    options = {"rand_seed": 5, "distribution_mode": "easy"}
    with (
        client.create_pool("maze", 2, **options) as pool,
        client.create_pool("maze", 2, transport="stream", **options) as stream,
    ):
        for _ in range(12):  # More than held_batches_max.
            kept.append(pool.step([7, -1], final_observations=True))
            want = stream.step([7, -1], final_observations=True)
            for name in ("observations", "final_observations"):
                np.testing.assert_array_equal(getattr(kept[-1], name), getattr(want, name))
        assert all(batch.observations.flags.writeable for batch in kept)
        assert not any(np.shares_memory(kept[0].observations, b.observations) for b in kept[1:])
    with client.create_pool("maze", 2, copy=False) as pool:
        assert not pool.step([7, 7]).observations.flags.writeable
