"""A program without a server address starts a local server, which ends with the program."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import server_binary

import procgen_client
from procgen_client import Client, ServerProcess, errors
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


def test_program_of_a_wheel_is_found(tmp_path: Path) -> None:
    shutil.copytree(Path(procgen_client.__file__).parent, tmp_path / "procgen_client")
    (tmp_path / "procgen_client/bin").mkdir()
    (tmp_path / "procgen_client/bin/procgen-server").symlink_to(server_binary())
    run = subprocess.run(
        [sys.executable, "-c", _BEGIN],
        env=_environment(PROCGEN_SERVER_BINARY="", PATH="/bin", PYTHONPATH=str(tmp_path)),
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr


_OTHER_ART = """
import sys
import numpy as np
from procgen_client import ProcgenEnv, errors
options = {"num_envs": 2, "env_name": "maze", "rand_seed": 3}
one = ProcgenEnv(**options)
other = ProcgenEnv(**options, resource_root=sys.argv[1] + "/")
for env in (other, ProcgenEnv(**options, resource_root=sys.argv[1])):
    assert env.env.pool._client.address == other.env.pool._client.address
    assert not np.array_equal(one.reset()["rgb"], env.reset()["rgb"])
assert one.env.pool._client.address != other.env.pool._client.address
"""


def _run_with_art(folder: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", _OTHER_ART, folder],
        env=_environment(),
        capture_output=True,
        text=True,
        check=False,
    )


def test_each_art_dir_has_its_own_server() -> None:
    art = os.environ.get("PROCGEN_PAINTED_ART_DIR")
    if art is None:
        pytest.skip("PROCGEN_PAINTED_ART_DIR is not set; CTest sets it")
    run = _run_with_art(os.path.dirname(art))
    assert run.returncode == 0, run.stderr


def test_folder_without_art_is_rejected(tmp_path: Path) -> None:
    assert f"art folder '{tmp_path}'" in _run_with_art(str(tmp_path)).stderr


def test_tied_server_stops_like_any_other(tmp_path: Path) -> None:
    address = f"unix:{tmp_path}/socket"
    with ServerProcess(server_binary(), address=address, tied=True) as server:
        assert server.address == address
        assert _is_served(address)
        assert server.stop() == 0
        assert server.stop() == 0
    with pytest.raises(errors.UnavailableError, match="status 1"):
        ServerProcess(server_binary(), ["--no_such_flag"], tied=True)
