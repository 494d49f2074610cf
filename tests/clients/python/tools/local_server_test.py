"""A program without a server address starts a local server, which ends with the program."""

from __future__ import annotations

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import native_only, server_binary

import procgen_client
from procgen_client import Client, ProcgenVectorEnv, ServerProcess, errors
from procgen_client.tools.local_server import SERVER_VARIABLE

_BEGIN = """
import sys
import numpy as np
from procgen_client import ProcgenEnv, ProcgenGymEnv, ProcgenVectorEnv
env = ProcgenEnv(num_envs=3, env_name="coinrun")
env.reset()
env.step(np.full(3, 7))
"""

_TWO_OF_ONE_SERVER = (
    _BEGIN
    + """
vector = ProcgenVectorEnv("maze", 2)
assert vector.pool._client.address == env.env.pool._client.address
for each in (env.env.pool, vector.pool):
    assert each.spec.transport == 2, "shared memory"
encoded = ProcgenVectorEnv("maze", 2, encoding="delta_zstd")
assert encoded.pool.spec.transport == 1, "the stream"
vector.reset()
vector.step([4, 4])
ProcgenGymEnv("maze").reset()
print(vector.pool._client.address)
"""
)

_WAITS = _BEGIN + "print(env.env.pool._client.address, flush=True)\nsys.stdin.read()\n"


def _environment(**changes: str) -> dict[str, str]:
    environment = os.environ | {"PROCGEN_SERVER_BINARY": str(server_binary())} | changes
    return {name: value for name, value in environment.items() if value}


def _is_served(address: str) -> bool:
    with socket.socket(socket.AF_UNIX) as line:
        return line.connect_ex(str(_socket(address))) == 0


def _socket(address: str) -> Path:
    return Path(address.removeprefix("unix:"))


@native_only
def test_environments_share_one_server_that_ends_with_the_program() -> None:
    run = subprocess.run(
        [sys.executable, "-c", _TWO_OF_ONE_SERVER],
        env=_environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    address = run.stdout.strip()
    assert address.startswith("unix:")
    assert not _socket(address).parent.exists()


def test_killed_program_leaves_no_server() -> None:
    with subprocess.Popen(
        [sys.executable, "-c", _WAITS],
        env=_environment(),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as program:
        assert program.stdout is not None
        address = program.stdout.readline().strip()
        assert _is_served(address)
        os.kill(program.pid, signal.SIGKILL)
    while _is_served(address):
        pass
    folder = _socket(address).parent
    assert folder.name.startswith("procgen-server-")
    for file in folder.iterdir():
        file.unlink(missing_ok=True)  # the server may remove it, too
    folder.rmdir()


def test_environment_variable_selects_another_server(server: ServerProcess, client: Client) -> None:
    address = server.address
    run = subprocess.run(
        [sys.executable, "-c", _BEGIN + "print(env.env.pool._client.address)"],
        env=_environment(**{SERVER_VARIABLE: address}),
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.stdout.strip() == address, run.stderr
    assert client.list_pools() == []


def test_missing_server_binary_error_lists_what_was_tried(tmp_path: Path) -> None:
    # A copy: the checkout of the original may have a release build.
    package = Path(procgen_client.__file__).parent
    shutil.copytree(package, tmp_path / "procgen_client")
    run = subprocess.run(
        [sys.executable, "-c", _BEGIN],
        env=_environment(PROCGEN_SERVER_BINARY="", PATH="/", PYTHONPATH=str(tmp_path)),
        capture_output=True,
        text=True,
        check=False,
    )
    assert "ServerNotFoundError: NOT_FOUND: there is no server program; tried: " in run.stderr
    assert f"{tmp_path}/procgen_client/bin/procgen-server" in run.stderr
    assert "PROCGEN_SERVER_BINARY" in run.stderr


@pytest.mark.parametrize(
    "place", ["clients/python/procgen_client/bin", "build/release/bin", "on_path"]
)
def test_program_is_found_in_a_wheel_a_checkout_or_the_path(tmp_path: Path, place: str) -> None:
    package = tmp_path / "clients/python/procgen_client"
    shutil.copytree(Path(procgen_client.__file__).parent, package)
    (tmp_path / place).mkdir(parents=True)
    (tmp_path / place / "procgen-server").symlink_to(server_binary())
    run = subprocess.run(
        [sys.executable, "-c", _BEGIN],
        env=_environment(
            PROCGEN_SERVER_BINARY="",
            PATH=f"/bin:{tmp_path / 'on_path'}",
            PYTHONPATH=str(package.parent),
        ),
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr


# Hides what Windows does not have.
_ELSEWHERE = """
import os, signal, socket, sys
sys.modules["fcntl"] = sys.modules["pwd"] = sys.modules["resource"] = None
for module, names in (
    (os, ("register_at_fork", "fork", "getuid", "killpg", "eventfd")),
    (signal, ("SIGKILL", "pthread_sigmask")),
    (socket, ("AF_UNIX",)),
):
    for name in names:
        delattr(module, name)
from procgen_client import ProcgenVectorEnv
env = ProcgenVectorEnv("maze", 2, server=sys.argv[1])
env.reset()
env.step([4, 4])
env.close()
"""


def test_other_systems_need_no_unix_modules(server: ServerProcess) -> None:
    run = subprocess.run(
        [sys.executable, "-c", _ELSEWHERE, server.address],
        env=os.environ | {"PROCGEN_CLIENT_TRANSPORT": "grpcio"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr


_RANK = _BEGIN + """
print(env.env.pool._client.address, flush=True)
while sys.stdin.readline():
    env.step(np.full(3, 7))
    print("stepped", flush=True)
"""


def _start_rank(launcher: dict[str, str]) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", _RANK],
        env=_environment(**launcher),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def _end(rank: subprocess.Popen[str]) -> None:
    rank.stdin.close()
    assert rank.wait() == 0
    rank.stdout.close()


def _await(condition: Callable[[], bool]) -> None:
    while not condition():
        time.sleep(0.01)


@pytest.mark.parametrize(
    "launcher",
    [
        {"LOCAL_WORLD_SIZE": "2", "TORCHELASTIC_RUN_ID": "none"},
        {"SLURM_JOB_ID": "7", "SLURM_STEP_ID": "0"},
    ],
    ids=["torchrun", "slurm"],
)
@pytest.mark.parametrize("is_killed", [False, True])
def test_ranks_of_one_host_share_a_server_until_the_last_ends(
    launcher: dict[str, str], *, is_killed: bool, tmp_path: Path
) -> None:
    launcher = launcher | {"TMPDIR": str(tmp_path)}
    ranks = [_start_rank(launcher) for _ in range(3)]
    addresses = {rank.stdout.readline().strip() for rank in ranks}
    (address,) = addresses
    with Client(address) as client:
        assert len(client.list_pools()) == 3
    for rank in ranks[:2]:  # One of them may be the one that started the server.
        if is_killed:
            rank.kill()
            rank.wait()
        _end_pipes(rank) if is_killed else _end(rank)
    ranks[2].stdin.write("step\n")
    ranks[2].stdin.flush()
    assert ranks[2].stdout.readline() == "stepped\n"
    late = _start_rank(launcher)
    assert late.stdout.readline().strip() == address
    _end(ranks[2])
    _end(late)
    _await(lambda: not _is_served(address))
    next_job = _start_rank(launcher)  # Perhaps while the folder is removed.
    assert next_job.stdout.readline().strip() == address
    _end(next_job)
    _await(lambda: not _socket(address).parent.exists())


def _end_pipes(rank: subprocess.Popen[str]) -> None:
    rank.stdin.close()
    rank.stdout.close()


def test_ranks_refuse_a_folder_that_is_open_to_others(tmp_path: Path) -> None:
    launcher = {"SLURM_JOB_ID": "7", "SLURM_STEP_ID": "0", "TMPDIR": str(tmp_path)}
    first = _start_rank(launcher)
    folder = _socket(first.stdout.readline().strip()).parent
    _end(first)
    _await(lambda: not folder.exists())
    folder.mkdir(mode=0o755)
    run = subprocess.run(
        [sys.executable, "-c", _BEGIN],
        env=_environment(**launcher),
        capture_output=True,
        text=True,
        check=False,
    )
    assert f"{folder} belongs to another user or is open to others" in run.stderr


def test_server_process_takes_workers_and_web_address(tmp_path: Path) -> None:
    log = tmp_path / "log"
    with ServerProcess(
        server_binary(), workers=3, web_address="127.0.0.1:0", log_path=log
    ) as server:
        assert "workers=3" in log.read_text()
        (url,) = re.findall(r"web=(http://127.0.0.1:\d+)", log.read_text())
        assert urllib.request.urlopen(url).status == 200
        with ProcgenVectorEnv("maze", 2, server=server) as env:
            assert env.reset()[0].shape == (2, 64, 64, 3)


def test_tied_server_stops_like_any_other(tmp_path: Path) -> None:
    address = f"unix:{tmp_path}/socket"
    with ServerProcess(server_binary(), address=address, tied=True) as server:
        assert server.address == address
        assert _is_served(address)
        assert server.stop() == 0
        assert server.stop() == 0
    with pytest.raises(errors.UnavailableError, match="status 2"):
        ServerProcess(server_binary(), ["--no_such_flag"], tied=True)
