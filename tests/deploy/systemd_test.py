"""The service under systemd, with the restrictions of its unit."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

import procgen_client

_HERE = Path(__file__).resolve().parent
_PACKAGES = Path(os.environ["PROCGEN_PACKAGES"])
_NAMESPACES = ("--mount", "--pid", "--net", "--ipc", "--uts", "--cgroup")

# Each line must succeed.
_PROBE = """#!/bin/bash
set -eux -o pipefail
export PYTHONPATH=/probe
trap 'systemctl status --no-pager procgen-server' ERR
dpkg --purge procgen-server
dpkg --install /probe/procgen-server.deb
systemctl is-enabled procgen-server
python3 /probe/nodes.py
main() { systemctl show --property=MainPID --value procgen-server; }
grep -E 'NoNewPrivs|CapEff|Seccomp:' /proc/$(main)/status
runuser -u procgen-server -- python3 /probe/learner.py
kill -9 $(main)
python3 /probe/nodes.py
systemctl show --property=NRestarts procgen-server
dpkg --install /probe/procgen-server.deb
python3 /probe/nodes.py
printf '%s\\n' --cluster=probe --node_id=alone >> /etc/procgen-server/server.flags
systemctl restart procgen-server
python3 /probe/nodes.py
systemctl stop procgen-server
systemctl show --property=Result procgen-server
systemctl start procgen-server
dpkg --purge procgen-server
systemctl is-active procgen-server || true
"""

# Waits for the server, and prints the nodes of its cluster, or the server alone.
_NODES = """
from procgen_client import Client
with Client("127.0.0.1:50051", timeout=10) as client:
    for node in client.list_nodes().nodes:
        print(node.name, "serving" if node.healthy else "unhealthy")
"""

_LEARNER = """
from procgen_client import Client
with Client("127.0.0.1:50051") as client:
    with client.create_pool("coinrun", 2) as pool:
        states = pool.save_states()
        print("pixels", pool.step([7, 7]).observations.max() > 0)
        pool.restore_states(states)
"""


@pytest.fixture(scope="module")
def said(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The output of the probe in a system booted by systemd."""
    if not Path("/lib/systemd/systemd").exists() or os.geteuid() != 0:
        pytest.skip("booting systemd needs systemd and root")
    folder = tmp_path_factory.mktemp("boot")
    (package,) = _PACKAGES.glob("procgen-server_*.deb")
    shutil.copy(package, folder / "procgen-server.deb")
    shutil.copytree(Path(procgen_client.__file__).parent, folder / "procgen_client")
    library = folder / "procgen_client" / "libprocgen_remote.so.1"
    shutil.copy(os.environ["PROCGEN_REMOTE_LIBRARY"], library)
    (folder / "nodes.py").write_text(_NODES)
    (folder / "learner.py").write_text(_LEARNER)
    (folder / "probe").write_text(_PROBE)
    (folder / "probe").chmod(0o755)
    folder.chmod(0o755)  # The service's user must read the learner.
    booted = subprocess.run(
        ["unshare", *_NAMESPACES, "--fork", "--kill-child", _HERE / "boot.sh", folder],
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    if not (folder / "status").exists():
        pytest.skip(f"systemd cannot be booted here: {booted.stderr.strip()}")
    output = (folder / "output").read_text()
    assert (folder / "status").read_text() == "0\n", output
    return output


def test_the_package_starts_and_restarts_the_service(said: str) -> None:
    assert re.search(r"^enabled$", said, re.MULTILINE)
    assert len(re.findall(r"^nodes/\S+ serving$", said, re.MULTILINE)) == 4


def test_the_service_can_be_a_cluster_node(said: str) -> None:
    assert re.search(r"^nodes/alone serving$", said, re.MULTILINE)


def test_the_service_has_minimal_privileges(said: str) -> None:
    assert re.search(r"^CapEff:\s+0+$", said, re.MULTILINE)
    assert re.search(r"^NoNewPrivs:\s+1$", said, re.MULTILINE)
    assert re.search(r"^Seccomp:\s+2$", said, re.MULTILINE)


def test_a_learner_steps_on_the_service(said: str) -> None:
    assert "pixels True" in said


def test_the_service_restarts_after_a_crash(said: str) -> None:
    assert "NRestarts=1" in said


def test_stop_is_not_a_failure_and_purge_stops_the_service(said: str) -> None:
    assert "Result=success" in said
    assert re.search(r"^inactive$", said, re.MULTILINE)
