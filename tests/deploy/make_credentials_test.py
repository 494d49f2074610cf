"""`deploy/make-credentials.sh`: its files serve a learner with the three printed lines."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from procgen_client import Client, Credentials, ServerProcess, errors

_SCRIPT = Path(__file__).parents[2] / "deploy/make-credentials.sh"
_FILES = ["ca.key", "ca.pem", "server.key", "server.pem", "tokens"]


def _make(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [_SCRIPT, folder, *arguments], capture_output=True, text=True, check=False
    )


def _serve(printed: str) -> ServerProcess:
    """Starts a server with the printed flags, on a free port of loopback."""
    flags = [line for line in printed.splitlines() if line.startswith("--")]
    assert flags[0] == "--address=0.0.0.0:50051"
    return ServerProcess(None, ["--workers=1", *flags[1:]], address="127.0.0.1:0")


def test_learner_connects_with_the_printed_lines(tmp_path: Path) -> None:
    folder = tmp_path / "new/credentials"
    made = _make(folder, "127.0.0.1,localhost,::1,lab.example.com", "alice")
    assert made.returncode == 0, made.stderr
    assert sorted(path.name for path in folder.iterdir()) == _FILES
    for path in folder.iterdir():
        assert path.stat().st_mode & 0o777 == (0o644 if path.suffix == ".pem" else 0o600)
    assert re.fullmatch("alice [0-9a-f]{64}\n", (folder / "tokens").read_text())
    lines = [line for line in made.stdout.splitlines() if line.startswith("export ")]
    assert len(lines) == 3
    assert lines[0] == "export PROCGEN_SERVER=127.0.0.1:50051"
    with _serve(made.stdout) as server:
        port = server.address.rpartition(":")[2]
        for host in ("127.0.0.1", "localhost"):
            lines[0] = f"export PROCGEN_SERVER={host}:{port}"
            learner = (
                "from procgen_client import ProcgenVectorEnv;"
                "env = ProcgenVectorEnv('maze', 2); env.reset(); env.step([4, 4]);"
                "print(env.pool.client.list_pools()[0].owner)"
            )
            script = "\n".join([*lines, f'exec {sys.executable} -c "{learner}"'])
            run = subprocess.run(
                ["sh", "-c", script], capture_output=True, text=True, check=False
            )
            assert run.stdout == "alice\n", run.stderr


def test_certificate_is_for_the_given_names_only(tmp_path: Path) -> None:
    made = _make(tmp_path, "lab.example.com")
    token = (tmp_path / "tokens").read_text().split()[1]
    with _serve(made.stdout) as server:
        credentials = Credentials(ca=tmp_path / "ca.pem", token=token)
        with pytest.raises(errors.UnavailableError, match="is for other names"):
            Client(server.address, credentials=credentials)


def test_openssl_accepts_the_chain(tmp_path: Path) -> None:
    assert _make(tmp_path, "lab.example.com,192.0.2.7").returncode == 0
    for purpose, accepted in (("sslserver", True), ("sslclient", False)):
        command = ["openssl", "verify", "-x509_strict", "-CAfile", "ca.pem", "-purpose", purpose]
        run = subprocess.run([*command, "server.pem"], cwd=tmp_path, check=False)
        assert (run.returncode == 0) is accepted


@pytest.mark.parametrize("name", _FILES)
def test_existing_files_are_not_overwritten(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("mine")
    made = _make(tmp_path, "localhost")
    assert made.returncode == 2
    assert f"{tmp_path}/{name} exists and is not overwritten" in made.stderr
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "mine"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "Usage: make-credentials.sh FOLDER HOST"),
        ([""], "HOST is missing"),
        (["localhost:50051"], "host 'localhost:50051', allowed: DNS names"),
        (["a,DNS:b"], "host 'DNS:b', allowed"),
        (["999.1.1.1"], "openssl rejects the hosts 999.1.1.1"),
        (["a", "al ice"], "owner 'al ice', allowed: 1 to 128 printable"),
        (["a", "#"], "owner '#', allowed"),
    ],
)
def test_wrong_arguments_are_rejected(
    tmp_path: Path, arguments: list[str], message: str
) -> None:
    made = _make(tmp_path, *arguments)
    assert made.returncode == 2
    assert message in made.stderr
    assert os.listdir(tmp_path) == []
