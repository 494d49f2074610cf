"""deploy/quickstart.sh: its flags, the demonstration, and cleanup.

Runs the demonstration with the server of this build; quickstart.sh would build another one.
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

import pytest
from PIL import Image

from procgen_client import Client, errors
from procgen_client.tools.server_process import BINARY_VARIABLE

_DEPLOY = Path(__file__).resolve().parents[2] / "deploy"
_BINARY = os.environ[BINARY_VARIABLE]


def quickstart(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [_DEPLOY / "quickstart.sh", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd="/")


def demonstration(*arguments: str, directory: Path) -> subprocess.Popen[str]:
    flags = ["--binary", _BINARY, "--environments", "4", "--log", directory / "server.log"]
    return subprocess.Popen(
        [sys.executable, _DEPLOY / "quickstart.py", *flags, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=directory,
    )


def server_log(directory: Path) -> str:
    return (directory / "server.log").read_text()


def test_help_names_every_flag() -> None:
    result = quickstart("--help")
    assert result.returncode == 0
    for flag in ("--keep", "--nodes", "--seconds", "--environments", "--output"):
        assert flag in result.stdout


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--fast"], "unknown argument '--fast'"),
        (["--seconds"], "--seconds needs a value"),
        (["--seconds=soon"], "--seconds is 'soon'; it is a number from 1 to 600"),
        (["--nodes", "0"], "--nodes is '0'; it is a number from 1 to 8"),
        (["--environments", "1"], "--environments is '1'; it is a number from 2 to 4096"),
        (["--output", "games.jpg"], "it ends in .png"),
        (["--output=/no/such/folder/games.png"], "there is no folder /no/such/folder"),
    ],
)
def test_an_invalid_flag_is_rejected_first(
    arguments: list[str], message: str
) -> None:
    result = quickstart(*arguments)
    assert result.returncode == 2
    assert message in result.stderr
    assert result.stdout == ""


def listed(*flags: str) -> set[str]:
    command = [_DEPLOY / "install-dependencies.sh", *flags, "--list"]
    return set(subprocess.run(command, capture_output=True, text=True, check=True).stdout.split())


def test_build_dependencies_exclude_test_dependencies() -> None:
    for_building, for_tests = listed(), listed("--tests")
    assert for_building < for_tests
    only_for_tests = {"chromium-headless-shell", "nodejs", "kubernetes-client", "ffmpeg", "mypy"}
    assert only_for_tests <= for_tests - for_building
    assert {"libgtest-dev", "python3-pytest"} <= for_tests - for_building
    assert {"g++", "libgrpc++-dev", "python3-protobuf", "python3-numpy"} <= for_building


def test_slow_tests_build_the_documentation_site() -> None:
    for_site = listed("--docs") - listed()
    assert {"python3-sphinx", "python3-myst-parser"} <= for_site <= listed("--slow")


def test_the_library_needs_no_package_of_the_server() -> None:
    assert listed("--library") < listed("--wheel")
    assert not {"libgrpc++-dev", "libssl-dev"} & listed("--library")
    assert "libabsl-dev:arm64" in listed("--library", "--aarch64")


@pytest.mark.parametrize(
    ("script", "flags"),
    [
        ("deploy/quickstart.sh", ""),
        ("tests/run.sh", "--tests"),
        ("clients/python/build_wheel.sh", "--library"),
    ],
)
def test_each_script_installs_what_it_uses(script: str, flags: str, tmp_path: Path) -> None:
    copy = tmp_path / script
    copy.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(_DEPLOY.parent / script, copy)
    installer = tmp_path / "deploy/install-dependencies.sh"
    installer.parent.mkdir(exist_ok=True)
    installer.write_text('#!/bin/sh\necho "asked for: $*"\nexit 3\n')
    installer.chmod(0o755)
    result = subprocess.run([copy], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert (result.returncode, result.stdout) == (3, f"asked for: {flags}\n")


def test_a_pool_survives_the_loss_of_a_server(tmp_path: Path) -> None:
    process = demonstration("--seconds", "0.1", "--nodes", "3", "--keep", directory=tmp_path)
    output, complaints = process.communicate()
    assert (process.returncode, complaints) == (0, "")
    address = re.search(r"servers keep running at (\S+) ", output).group(1)
    assert address.count(",") == 2
    servers = [int(number) for number in re.search(r"kill ((?:\d+ ?){4})", output).group(1).split()]
    victim = int(re.search(r"kill -9 (\d+)", output).group(1))
    assert victim in servers[:3]
    try:
        with Client(address) as client, client.create_pool("maze", 6, rand_seed=1) as pool:
            pool.step([4] * 6)
            os.kill(victim, signal.SIGKILL)
            for _ in range(20):
                assert pool.step([4] * 6).env_count == 6
    finally:
        for number in servers:
            with contextlib.suppress(ProcessLookupError):
                os.kill(number, signal.SIGKILL)


def test_it_prints_rates_draws_the_games_and_stops(tmp_path: Path) -> None:
    process = demonstration("--seconds", "0.1", directory=tmp_path)
    output, complaints = process.communicate()
    assert (process.returncode, complaints) == (0, "")
    assert "\r" not in output  # Not a terminal: one line per game.
    table = re.findall(r"^(\w+) +[\d,]+ +[\d,]+$", output, re.MULTILINE)
    assert {"bigfish", "coinrun", "maze", "miner"} <= set(table)
    with Image.open(tmp_path / "quickstart.png") as picture:
        assert picture.height > 256 * len(table)
    assert "event=stopped" in server_log(tmp_path)


def test_keep_leaves_a_server_and_prints_how_to_stop_it(tmp_path: Path) -> None:
    process = demonstration("--seconds", "0.1", "--keep", directory=tmp_path)
    output, complaints = process.communicate()
    assert (process.returncode, complaints) == (0, "")
    server_id = int(re.search(r"kill (\d+)", output).group(1))
    try:
        address = re.search(r"server keeps running at (\S+)", output).group(1)
        with Client(address) as client:
            while [pool.name for pool in client.list_pools()] != ["pools/watch-me"]:
                time.sleep(0.05)  # Polls until it appears.
        page = re.search(r"^See it: +(http://127.0.0.1:\d+/) ", output, re.MULTILINE).group(1)
        assert f"See it in a browser: {page}" in output
        with urllib.request.urlopen(page) as answer:
            assert answer.status == 200
    finally:
        os.kill(server_id, signal.SIGTERM)
    with pytest.raises(errors.UnavailableError):
        while True:  # It drains, may cancel calls, and then ends.
            with contextlib.suppress(errors.CancelledError), Client(address, timeout=0.3) as client:
                client.load()
            time.sleep(0.05)


@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_stops_the_server(tmp_path: Path, end: signal.Signals) -> None:
    process = demonstration("--seconds", "100", directory=tmp_path)
    assert process.stdout is not None
    process.stdout.readline()  # The first line: the server is running.
    process.send_signal(end)
    _, complaints = process.communicate()
    assert process.returncode == 128 + end, complaints
    assert "event=stopped" in server_log(tmp_path)


def test_a_failed_server_start_is_reported(tmp_path: Path) -> None:
    process = subprocess.run(
        [sys.executable, _DEPLOY / "quickstart.py", "--binary", "/no/such/server"],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
    )
    assert process.returncode == 1
    assert "tried: /no/such/server" in process.stderr
    assert "Traceback" not in process.stderr
