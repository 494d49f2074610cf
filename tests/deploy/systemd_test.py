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

# Each line must succeed. procgen-top waits up to ten seconds for the server.
_PROBE = """#!/bin/bash
set -eux -o pipefail
trap 'systemctl status --no-pager procgen-server' ERR
dpkg --purge procgen-server
dpkg --install /probe/procgen-server.deb
systemctl is-enabled procgen-server
procgen-top --once --interval=100ms
main() { systemctl show --property=MainPID --value procgen-server; }
grep -E 'NoNewPrivs|CapEff|Seccomp:' /proc/$(main)/status
runuser -u procgen-server -- env PYTHONPATH=/probe python3 /probe/learner.py
kill -9 $(main)
procgen-top --once --interval=100ms
systemctl show --property=NRestarts procgen-server
dpkg --install /probe/procgen-server.deb
procgen-top --once --interval=100ms
printf '%s\\n' --cluster=probe --node_id=alone >> /etc/procgen-server/server.flags
systemctl restart procgen-server
procgen-top --once --interval=100ms
systemctl stop procgen-server
systemctl show --property=Result procgen-server
systemctl start procgen-server
dpkg --purge procgen-server
systemctl is-active procgen-server || true
"""

_LEARNER = """
from procgen_client import Client
with Client("127.0.0.1:50051") as client:
    with client.create_pool("coinrun", 2, transport="shared_memory") as pool:
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
    assert said.count("procgen-server 0.") == 4


def test_the_service_can_be_a_cluster_node(said: str) -> None:
    assert re.search(r"^nodes/alone .* serving ", said, re.MULTILINE)


def test_the_service_has_minimal_privileges(said: str) -> None:
    assert re.search(r"^CapEff:\s+0+$", said, re.MULTILINE)
    assert re.search(r"^NoNewPrivs:\s+1$", said, re.MULTILINE)
    assert re.search(r"^Seccomp:\s+2$", said, re.MULTILINE)


def test_the_service_can_share_memory(said: str) -> None:
    assert "pixels True" in said


def test_the_service_restarts_after_a_crash(said: str) -> None:
    assert "NRestarts=1" in said


def test_stop_is_not_a_failure_and_purge_stops_the_service(said: str) -> None:
    assert "Result=success" in said
    assert re.search(r"^inactive$", said, re.MULTILINE)
