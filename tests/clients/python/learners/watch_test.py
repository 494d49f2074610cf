"""A finished run is played for viewers."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from small_runs import STEPS_OF_UPDATE, train, train_rainbow

from learners import watch
from procgen_client import Client, ServerProcess
from procgen_client._proto import render_pb2


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
