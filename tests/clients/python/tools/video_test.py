"""Videos contain the captured frames; errors of ffmpeg are reported."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from procgen_client import Client, VideoRecorder, errors

_NEEDS_FFMPEG = pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is missing")


def _frames(path: Path, width: int, height: int) -> np.ndarray:
    """Decodes a video: uint8 [frames, height, width, 3]."""
    decoded = subprocess.run(
        ["ffmpeg", "-loglevel", "error", "-i", path, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"],
        capture_output=True,
        check=True,
    )
    return np.frombuffer(decoded.stdout, np.uint8).reshape(-1, height, width, 3)


@_NEEDS_FFMPEG
def test_video_contains_the_captured_frames(client: Client, tmp_path: Path) -> None:
    path = tmp_path / "three.mp4"
    pictures = []
    with client.create_pool("coinrun", 4, distribution_mode="easy", rand_seed=1) as pool:
        with VideoRecorder(pool, path, environments=[2, 0, 1], size_px=96) as video:
            for _ in range(10):
                video.capture()
                pictures.append(pool.render([2, 0, 1], size_px=96))
                pool.step([7] * 4)
            assert video.frame_count == 10
    frames = _frames(path, 192, 192).astype(int)
    assert len(frames) == 10
    for frame, (first, second, third) in zip(frames, pictures, strict=True):
        # The codec is lossy; another environment's frame would differ far more.
        assert abs(frame[:96, :96] - first).mean() < 12
        assert abs(frame[:96, 96:] - second).mean() < 12
        assert abs(frame[96:, :96] - third).mean() < 12
        assert frame[96:, 96:].mean() < 12


@_NEEDS_FFMPEG
def test_odd_frame_sizes_are_padded(client: Client, tmp_path: Path) -> None:
    path = tmp_path / "odd.mp4"
    with client.create_pool("maze", 1) as pool:
        video = VideoRecorder(pool, path, size_px=65)
        video.capture()
        video.close()
        video.close()
    assert _frames(path, 66, 66).shape[0] == 1


@_NEEDS_FFMPEG
def test_ffmpeg_errors_are_reported(client: Client, tmp_path: Path) -> None:
    with client.create_pool("maze", 1) as pool:
        video = VideoRecorder(pool, tmp_path / "no such folder" / "a.mp4", size_px=512)
        with pytest.raises(OSError, match="No such file"):
            while True:
                video.capture()
        with pytest.raises(OSError, match="No such file"):
            video.close()


def test_missing_ffmpeg_is_reported(
    client: Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with client.create_pool("maze", 1) as pool:
        with pytest.raises(FileNotFoundError, match="ffmpeg"):
            VideoRecorder(pool, tmp_path / "a.mp4")


@_NEEDS_FFMPEG
def test_invalid_arguments_are_rejected(client: Client, tmp_path: Path) -> None:
    with client.create_pool("maze", 1) as pool:
        for arguments, message in (
            ({"environments": []}, "environments is empty"),
            ({"size_px": 8}, "size_px is 8"),
            ({"frames_per_second": 0}, "frames_per_second is 0"),
        ):
            with pytest.raises(errors.InvalidArgumentError, match=message):
                VideoRecorder(pool, tmp_path / "a.mp4", **arguments)
    assert not list(tmp_path.iterdir())
