"""Trajectory files keep everything, and damage is an error."""

from __future__ import annotations

import dataclasses
import json
import re
from pathlib import Path

import numpy as np
import pytest
from small_recordings import recorded, small_trajectories

from procgen_client import errors
from procgen_client.dataset import Trajectories, load
from procgen_client.dataset.trajectories import SUFFIX, find


@pytest.fixture(scope="module")
def small() -> Trajectories:
    """Trajectories."""
    return small_trajectories()


def test_file_keeps_everything(small: Trajectories, tmp_path: Path) -> None:
    small.save(tmp_path / "a")
    read = load(tmp_path / "a")
    assert read.header == small.header
    for field in dataclasses.fields(Trajectories)[1:]:
        one, other = getattr(small, field.name), getattr(read, field.name)
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_episodes_begin_after_ends(small: Trajectories) -> None:
    assert small.first[:, 0].all()
    np.testing.assert_array_equal(small.first[:, 1:], small.terminated | small.truncated)
    assert small.ended.sum() > 10


def test_damaged_files_are_errors(small: Trajectories, tmp_path: Path) -> None:
    path = tmp_path / "a"
    small.save(path)
    whole = path.read_bytes()
    for damaged in (b"", b"text", whole[:-10], whole[:200], whole.replace(b"header", b"reader")):
        path.write_bytes(damaged)
        with pytest.raises(errors.DataLossError, match="is not a trajectory file, or is damaged"):
            load(path)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"version": 9}, "has version 9 of the format; this program reads 1"),
        ({"format": "other"}, "it has another format"),
        ({"step_count": 101}, "actions is int8 [3, 100]; it is int8 [3, 101]"),
        ({"digest_interval": 0}, "digest_interval is 0; it is in [1,"),
        ({"unknown": 1}, "unknown"),
    ],
)
def test_wrong_headers_are_errors(
    small: Trajectories, tmp_path: Path, changes: dict, message: str
) -> None:
    path = tmp_path / "a.npz"
    small.save(path)
    with np.load(path) as archive:
        arrays = dict(archive)
    header = json.loads(arrays["header"].tobytes()) | changes
    arrays["header"] = np.frombuffer(json.dumps(header).encode(), np.uint8)
    np.savez(path, **arrays)
    with pytest.raises(errors.DataLossError, match=re.escape(message)):
        load(path)


def test_the_first_difference_is_reported(small: Trajectories) -> None:
    small.require_equal(small, "x")
    rewards = small.rewards.copy()
    rewards[2, 40] += 1
    rewards[0, 41] += 1
    expected = r"x: rewards of environment 2 at step 40 was recorded as .* and is replayed as "
    with pytest.raises(errors.DataLossError, match=expected):
        small.require_equal(dataclasses.replace(small, rewards=rewards), "x")
    digests = small.frame_digests ^ np.array([0, 1], np.uint32)
    header = dataclasses.replace(small.header, engine="9", art="other")
    expected = "x: frames at step 64 differ .* drawn with other; recorded by .* replayed by 9"
    with pytest.raises(errors.DataLossError, match=expected):
        small.require_equal(
            dataclasses.replace(small, frame_digests=digests, header=header), "x"
        )


def test_folders_are_complete(tmp_path: Path) -> None:
    files = recorded(tmp_path, env_count=130, step_count=130)
    assert len(files) == 3
    assert find([tmp_path]) == files
    assert find([files[2], files[0]]) == [files[2], files[0]]
    files[1].unlink()
    with pytest.raises(errors.InvalidArgumentError, match="has 2 of 3 parts of bigfish: repeat"):
        find([tmp_path])
    with pytest.raises(errors.NotFoundError, match="does not exist"):
        find([files[1]])
    (tmp_path / "empty").mkdir()
    with pytest.raises(errors.NotFoundError, match=f"has no \\*{SUFFIX}"):
        find([tmp_path / "empty"])
