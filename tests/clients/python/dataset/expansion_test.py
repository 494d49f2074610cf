"""Expansions have the frames, actions, rewards and ends of the trajectories."""

from __future__ import annotations

import io
import tarfile
from pathlib import Path

import numpy as np
import pytest
from small_recordings import Frames, recorded

from procgen_client import errors
from procgen_client.dataset import load, replay
from procgen_client.dataset.expansion import Expansion, Replay, expand, finish, prepare
from procgen_client.dataset.formats import format_of

_SCALARS = ("actions", "rewards", "terminated", "truncated", "first", "level_seeds")


def _expand(paths: list[Path], expansion: Expansion) -> None:
    prepare(paths, expansion)
    for path in paths:
        expand(Replay(path, expansion))
    finish(paths, expansion)


def _contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """A recording of two parts; 70 environments take 64 steps."""
    return recorded(tmp_path_factory.mktemp("data"), env_count=70, step_count=70)


def test_npz_has_all_segments(files: list[Path], tmp_path: Path) -> None:
    _expand(files, Expansion("npz", tmp_path / "a", segment_length=24))
    for path in files:
        trajectories = load(path)
        frames = Frames()
        replay(trajectories, "", writer=frames)
        expected = {"observations": frames.all}
        expected |= {name: getattr(trajectories, name) for name in _SCALARS}
        name = path.name.split(".")[0]
        for i, steps in enumerate((slice(0, 24), slice(24, 48), slice(48, 64))):
            with np.load(tmp_path / "a" / f"{name}-{i:06d}.npz") as archive:
                assert set(archive.files) == set(expected)
                for each, array in expected.items():
                    assert archive[each].dtype == array.dtype
                    np.testing.assert_array_equal(archive[each], array[:, steps])
    assert len(list((tmp_path / "a").glob("*.npz"))) == 6


def test_tar_files_have_the_same_arrays(files: list[Path], tmp_path: Path) -> None:
    for name in ("npz", "webdataset"):
        _expand(files, Expansion(name, tmp_path / name, segment_length=40))
    keys = set()
    for path in sorted((tmp_path / "webdataset").glob("*.tar")):
        with np.load(tmp_path / "npz" / f"{path.stem}.npz") as archive, tarfile.open(path) as tar:
            names = tar.getnames()
            assert len(names) == len(archive["actions"]) * 7
            for name in names:
                key, _, array = name.partition(".")
                keys.add(key)
                file = tar.extractfile(name)
                assert file is not None
                given = np.load(io.BytesIO(file.read()))
                np.testing.assert_array_equal(
                    given, archive[array.removesuffix(".npy")][int(key[-2:])]
                )
    assert len(keys) == 140
    assert "bigfish-00001-of-00002-00000040-05" in keys


@pytest.mark.parametrize("name", ["npz", "webdataset"])
def test_missing_files_are_written_again_and_equal(
    files: list[Path], tmp_path: Path, name: str
) -> None:
    expansion = Expansion(name, tmp_path / "a")
    _expand(files, expansion)
    before = _contents(tmp_path / "a")
    times = {path: path.stat().st_mtime_ns for path in (tmp_path / "a").glob("bigfish*")}
    missing, kept = sorted(times)
    missing.unlink()
    _expand(files, expansion)
    assert _contents(tmp_path / "a") == before
    assert kept.stat().st_mtime_ns == times[kept]


def test_folder_has_one_expansion(files: list[Path], tmp_path: Path) -> None:
    prepare(files[:1], Expansion("npz", tmp_path))
    prepare(files[1:], Expansion("npz", tmp_path))
    for other in (Expansion("webdataset", tmp_path), Expansion("npz", tmp_path, 32),
                  Expansion("npz", tmp_path, drawing={"screen_size": 32})):  # fmt: skip
        with pytest.raises(errors.InvalidArgumentError, match="has an expansion with .*, not with"):
            prepare(files, other)
    others = recorded(tmp_path / "other", env_count=70, step_count=70, seed=1)
    with pytest.raises(errors.InvalidArgumentError, match="has frames of another bigfish-0000"):
        prepare(others, Expansion("npz", tmp_path))
    with pytest.raises(errors.InvalidArgumentError, match="have the same name: expand them into"):
        prepare([*files, *others], Expansion("npz", tmp_path / "b"))


def test_damaged_recording_is_found_and_not_finished(files: list[Path], tmp_path: Path) -> None:
    trajectories = load(files[1])
    trajectories.level_seeds[3, 50] += 1
    trajectories.save(tmp_path / files[1].name)
    job = Replay(tmp_path / files[1].name, Expansion())
    with pytest.raises(errors.DataLossError, match="level_seeds of environment 3 at step 50"):
        expand(job)


def test_unknown_formats_are_errors() -> None:
    with pytest.raises(errors.InvalidArgumentError, match="it is one of npz, webdataset, minari"):
        format_of("jpeg")
    with pytest.raises(errors.InvalidArgumentError, match="segment_length is 0"):
        format_of("npz", 0)
