"""A process that forks keeps its pools; its children can make their own."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from conftest import server_binary

from procgen_client import ServerProcess

_CHILDREN_MAKE_THEIR_OWN = """
import multiprocessing
import sys

import numpy as np
from procgen_client import ProcgenGymEnv, ProcgenVectorEnv

def play(line, seed):
    env = ProcgenGymEnv("maze", distribution_mode="easy", rand_seed=seed)
    observation, _ = env.reset()
    line.send(int(observation.sum()) + sum(int(env.step(3)[0].sum()) for _ in range(5)))
    if line.recv() == "close":
        env.close()

def rounds(context, env):
    sums = []
    for _ in range(2):
        lines, processes = [], []
        for seed in range(3):
            near, far = context.Pipe()
            processes.append(context.Process(target=play, args=(far, seed)))
            processes[-1].start()
            lines.append(near)
            env.step(np.full(8, 7))
        for line in lines:
            assert line.poll(60), "a child hangs"
        sums.append([line.recv() for line in lines])
        env.save_states()
        for line, word in zip(lines, ("close", "end", "close")):
            line.send(word)
        for process in processes:
            process.join(60)
            assert process.exitcode == 0
        env.reset()
    assert sums == sums[:1] * 2, sums

if __name__ == "__main__":
    env = ProcgenVectorEnv("coinrun", 8, **eval(sys.argv[2]))
    env.reset(seed=1)
    rounds(multiprocessing.get_context(sys.argv[1]), env)
    env.step(np.full(8, 7))
    env.close()
"""

_THE_PARENTS_OWN = """
import os
import sys
from procgen_client import Pool, ProcgenVectorEnv, errors

def is_rejected(call, *arguments):
    try:
        call(*arguments)
    except errors.FailedPreconditionError as error:
        return f"process {os.getppid()}" in error.message or "unanswered" in error.message
    return False

def in_child(env, client):
    pool = env.pool
    calls = [env.reset, env.save_states, pool.observe, pool.send_observe, pool.render]
    if pool.in_flight:
        calls += [pool.receive, pool.observe]
    if client is not None:
        calls += [client.list_pools, client.load, lambda: client.create_pool("maze", 2)]
    wrong = [call for call in calls if not is_rejected(call)]
    if not is_rejected(env.step, [4, 4]):
        wrong.append(env.step)
    env.close()
    if client is not None:
        client.close()
    print(wrong)
    return 1 if wrong else 0

def rewards(pool):
    return [pool.step([t % 15, t % 7]).observations.sum() for t in range(50)]

env = ProcgenVectorEnv("maze", 2, server=sys.argv[1] or None)
env.reset()
for is_under_way in (False, True):
    if is_under_way:
        env.step_async([3, 3])
    child = os.fork()
    if child == 0:
        code = in_child(env, env.pool.client)
        sys.stdout.flush()
        sys.exit(code)  # And what finalizers do.
    _, status = os.waitpid(child, 0)
    assert os.waitstatus_to_exitcode(status) == 0
    if is_under_way:
        env.step_wait()
    env.step([4, 4])
    env.save_states()
env.close()
"""

_CONNECTS_IN_CHILD = """
import os
import sys
from procgen_client import Client, Pool, errors

client = Client(sys.argv[1])
pool = client.create_pool("maze", 2)
pool.step([4, 4])
child = os.fork()
if child == 0:
    for connect in (Client, lambda address: Pool("maze", 2, server=address)):
        try:
            connect(sys.argv[1])
            os._exit(1)
        except errors.FailedPreconditionError as error:
            assert f"forked from process {os.getppid()}" in error.message, error.message
            assert "spawn" in error.message
    Pool("maze", 2).step([4, 4])
    os._exit(0)
_, status = os.waitpid(child, 0)
assert os.waitstatus_to_exitcode(status) == 0
pool.step([4, 4])
pool.save_states()
pool.close()
client.close()
"""

_CHILD_OUTLIVES_IT = """
import os
import sys
from procgen_client import ServerProcess
server = ServerProcess(tied=True)
if os.fork() == 0:
    sys.stdin.read()
    os._exit(0)
print(server.address, flush=True)
sys.stdin.read()
"""


def _run(program: str, *arguments: str, folder: Path) -> None:
    file = folder / "program.py"
    file.write_text(program)
    run = subprocess.run(
        [sys.executable, "-W", "error::ResourceWarning", str(file), *arguments],
        env=_environment(),
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert run.returncode == 0, f"{run.returncode}\n{run.stdout}\n{run.stderr}"


def _environment() -> dict[str, str]:
    return os.environ | {"PROCGEN_SERVER_BINARY": str(server_binary())}


@pytest.mark.parametrize("how", ["fork", "spawn", "forkserver"])
def test_children_make_environments_while_the_parent_has_some(how: str, tmp_path: Path) -> None:
    _run(_CHILDREN_MAKE_THEIR_OWN, how, "{}", folder=tmp_path)


def test_children_make_environments_while_the_parent_has_some_on_a_server(
    server: ServerProcess, tmp_path: Path
) -> None:
    _run(_CHILDREN_MAKE_THEIR_OWN, "fork", repr({"server": server.address}), folder=tmp_path)


@pytest.mark.parametrize("place", ["process", "server"])
def test_child_can_neither_use_nor_close_its_parents_pools(
    place: str, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    address = request.getfixturevalue("server").address if place == "server" else ""
    _run(_THE_PARENTS_OWN, address, folder=tmp_path)


def test_child_of_a_connected_process_cannot_connect_but_can_make_pools_of_its_own(
    server: ServerProcess, tmp_path: Path
) -> None:
    _run(_CONNECTS_IN_CHILD, server.address, folder=tmp_path)


def test_tied_server_ends_with_its_program_despite_running_children() -> None:
    with subprocess.Popen(
        [sys.executable, "-c", _CHILD_OUTLIVES_IT],
        env=_environment(),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as program:
        assert program.stdout is not None
        _, _, port = program.stdout.readline().strip().rpartition(":")
        listening = f":{int(port):04X} 00000000:0000 0A"
        assert listening in Path("/proc/net/tcp").read_text()
        os.kill(program.pid, signal.SIGKILL)
        program.wait()
        deadline = time.monotonic() + 60
        while listening in Path("/proc/net/tcp").read_text():
            assert time.monotonic() < deadline, "the server is still running"
        # The child is still running: its standard input is open.
        assert program.stdin is not None
        assert not program.stdin.closed
