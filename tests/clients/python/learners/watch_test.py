"""A finished run is played for viewers."""

from __future__ import annotations

import concurrent.futures
import contextlib
import shutil
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

import pytest
from small_runs import STEPS_OF_UPDATE, options, train, train_rainbow

from learners import ppo, watch
from procgen_client import Client, ServerProcess
from procgen_client._proto import render_pb2
from procgen_client.errors import FailedPreconditionError


def test_viewers_see_steps_values_and_probabilities(
    server: ServerProcess, tmp_path: Path
) -> None:
    train(tmp_path / "run", total_steps=STEPS_OF_UPDATE)
    command = [sys.executable, "-m", "learners.watch", str(tmp_path / "run")]
    with subprocess.Popen(
        [*command, "--server", server.address],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as player:
        assert player.stdout is not None
        line = player.stdout.readline()
        assert line.startswith("playing pools/")
        name = line.split()[1].rstrip(";")
        with Client(server.address) as client:
            request = render_pb2.WatchPoolRequest(
                pool=name, environments=[15], size_px=64, with_steps=True
            )
            for response in client._watch("WatchPool", request, render_pb2.WatchPoolResponse):
                values = {each.name: each.values for each in response.frames[0].step.annotations}
                if values:
                    break
            assert len(values["value"]) == 1
            assert abs(sum(values["action_probabilities"]) - 1) < 1e-5
            player.send_signal(signal.SIGINT)
            assert player.wait(20) == 0, player.stderr.read()
            deadline = time.monotonic() + 20
            while any(pool.name == name for pool in client.list_pools()):
                assert time.monotonic() < deadline
                time.sleep(0.05)


def test_a_run_is_watched_on_the_pages_of_its_own_server(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{free.getsockname()[1]}"

    def page() -> str:
        while True:
            try:
                with urllib.request.urlopen(f"http://{address}/") as response:
                    return str(response.read(), "utf-8")
            except urllib.error.URLError:
                time.sleep(0.01)  # The server has not started yet.

    with concurrent.futures.ThreadPoolExecutor() as executor:
        shown = executor.submit(page)
        results = train(tmp_path / "watched", watch=address)
        assert "<title>Live" in shown.result()
    assert f"Pages: http://{address}" in capfd.readouterr().out
    assert results == train(tmp_path / "plain")
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(f"http://{address}/")


def test_values_and_probabilities_of_training_are_recorded(
    server: ServerProcess, tmp_path: Path
) -> None:
    def series() -> dict[str, int]:
        with Client(server.address) as client:
            while not (pools := list(client.list_pools())):
                time.sleep(0.01)
            while True:
                with contextlib.suppress(FailedPreconditionError):  # Between two episodes.
                    episode = client.get_episode(pools[0].name, 7, "current")
                    if found := {each.name: each.value_count for each in episode.annotations}:
                        return found
                time.sleep(0.01)

    with concurrent.futures.ThreadPoolExecutor() as executor:
        found = executor.submit(series)
        train(tmp_path / "run", server.address)
        assert found.result(60) == {"value": 1, "action_probabilities": 15}


def test_watch_with_a_server_is_rejected(
    server: ServerProcess, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ppo.main(options(tmp_path, server.address, watch="127.0.0.1:0")) == 1
    assert "allowed with environments in this process" in capsys.readouterr().err


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")
def test_policy_is_recorded_as_a_video(tmp_path: Path) -> None:
    train(tmp_path / "run", total_steps=STEPS_OF_UPDATE, frame_stack=2)
    path = tmp_path / "run.mp4"
    watch.main([str(tmp_path / "run"), "--video", str(path), "--environments", "4", "--steps", "9"])
    assert path.read_bytes()[4:8] == b"ftyp"


def test_other_folders_are_rejected(
    server: ServerProcess, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    train_rainbow(tmp_path / "rainbow", total_steps=STEPS_OF_UPDATE)
    for folder, problem in (("none", "has no checkpoint"), ("rainbow", "is a run of Rainbow")):
        with pytest.raises(SystemExit, match="2"):
            watch.main([str(tmp_path / folder), "--server", server.address])
        assert problem in capsys.readouterr().err
