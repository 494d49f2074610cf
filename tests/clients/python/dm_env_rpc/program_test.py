"""The program procgen-dm-env-rpc: its flags, errors and end."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
from pathlib import Path

import grpc
import pytest
from conftest import PROGRAM, Agent, Protocol


def _fails(environment: dict[str, str], *flags: str) -> str:
    """Runs the program, which must fail; returns the last line of its error output."""
    run = subprocess.run(
        [*PROGRAM, *flags], env=environment, capture_output=True, text=True, timeout=60,
        check=False,
    )
    assert run.returncode == 2
    assert "Traceback" not in run.stderr
    return run.stderr.splitlines()[-1]


def _start(environment: dict[str, str], *flags: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [*PROGRAM, *flags], env=environment, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )


def test_an_address_in_use_is_an_error(environment: dict[str, str]) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        address = f"127.0.0.1:{other.getsockname()[1]}"
        expected = f"procgen-dm-env-rpc: UNAVAILABLE: cannot listen on {address}"
        assert _fails(environment, f"--address={address}") == expected


def test_an_unreachable_server_is_an_error(environment: dict[str, str]) -> None:
    message = _fails(environment, "--address=127.0.0.1:0", "--server=127.0.0.1:1")
    assert message.startswith("procgen-dm-env-rpc: UNAVAILABLE: ")
    assert "127.0.0.1:1" in message


def test_missing_dm_env_rpc_is_named() -> None:
    assert "pip install dm-env-rpc" in _fails(dict(os.environ), "--address=127.0.0.1:0")


def test_the_default_address_is_of_this_machine() -> None:
    from procgen_client.dm_env_rpc.server import DEFAULT_ADDRESS

    assert DEFAULT_ADDRESS.startswith("127.0.0.1:")


def test_other_machines_are_warned_of(environment: dict[str, str]) -> None:
    with _start(environment, "--address=0.0.0.0:0") as process:
        assert process.stderr is not None
        assert "warning: other machines can use it" in process.stderr.readline()
        process.terminate()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_streams_and_the_program(
    environment: dict[str, str], protocol: Protocol, tmp_path: Path, number: int
) -> None:
    address = f"unix:{tmp_path}/socket"
    with _start(environment, f"--address={address}") as process:
        assert process.stdout is not None
        assert process.stdout.readline().endswith(f"worlds of this process on {address}\n")
        player, idle = Agent(protocol, address), Agent(protocol, address)
        player.join(player.create(env_name="maze"))
        idle.create(env_name="maze")
        stepping = Agent(protocol, address)
        stepping.join(stepping.create(env_name="maze", num_envs=8192))
        for _ in range(200):
            stepping.send(protocol.pb2.EnvironmentRequest(step={}))
        stepping.receive()
        process.send_signal(number)
        with pytest.raises(grpc.RpcError):
            while True:
                stepping.receive()
        stepping.close()  # The program ends when its step has.
        for agent in (player, idle):
            with pytest.raises(grpc.RpcError):
                next(agent.responses)
            agent.close()
        assert process.wait(30) == 0
        assert process.stderr is not None
        assert process.stderr.read() == ""
