"""Segments that are drawn when they are read equal those of an expansion."""

from __future__ import annotations

import os
import pickle
from pathlib import Path

import numpy as np
import pytest
from small_recordings import Frames, recorded

from procgen_client import errors
from procgen_client.dataset import TrajectoryDataset, load, replay

_SCALARS = ("actions", "rewards", "terminated", "truncated", "first", "level_seeds")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Recordings of two games."""
    folder = tmp_path_factory.mktemp("data")
    recorded(folder, "bigfish", env_count=66, step_count=66 * 128)
    recorded(folder, "coinrun", env_count=5, step_count=5 * 128)
    return folder


def _segments(paths: list[Path], length: int, stride: int) -> list[dict[str, np.ndarray]]:
    """All segments, from replays of whole files."""
    found = []
    for path in paths:
        trajectories = load(path)
        frames = Frames()
        replay(trajectories, "", writer=frames)
        arrays = {"observations": frames.all}
        arrays |= {name: getattr(trajectories, name) for name in _SCALARS}
        for env in range(trajectories.header.env_count):
            for t in range(0, trajectories.header.step_count - length + 1, stride):
                found.append({name: array[env, t : t + length] for name, array in arrays.items()})
    return found


def _assert_equal(one: dict[str, np.ndarray], other: dict[str, np.ndarray]) -> None:
    assert set(one) == set(other)
    for name, array in one.items():
        np.testing.assert_array_equal(array, other[name], err_msg=name)


@pytest.mark.parametrize(("length", "stride", "interval"), [(16, 16, 64), (10, 7, 20), (70, 64, 1)])
def test_segments_equal_a_replay(folder: Path, length: int, stride: int, interval: int) -> None:
    dataset = TrajectoryDataset(folder, length, stride=stride, snapshot_interval=interval)
    expected = _segments(dataset.paths, length, stride)
    assert len(dataset) == len(expected)
    order = np.random.default_rng(0).permutation(len(expected))
    for indices in np.array_split(order, 4):
        batch = dataset[indices]
        assert batch["actions"].dtype == np.int64
        for i, index in enumerate(indices):
            _assert_equal({name: array[i] for name, array in batch.items()}, expected[index])
    _assert_equal(dataset[-1], expected[-1])
    for sample, index in zip(dataset.__getitems__([5, 5, 0]), (5, 5, 0)):
        _assert_equal(sample, expected[index])
    dataset.close()


def test_snapshots_are_kept_until_the_file_changes(folder: Path, tmp_path: Path) -> None:
    (path,) = recorded(tmp_path, env_count=4, step_count=512)
    first = TrajectoryDataset(path)[[0, 20]]
    (cache,) = tmp_path.glob("*.snapshots.npz")
    written = cache.stat().st_mtime_ns
    _assert_equal(TrajectoryDataset(tmp_path)[[0, 20]], first)
    assert cache.stat().st_mtime_ns == written
    path.unlink()
    recorded(tmp_path, env_count=4, step_count=512, seed=9)
    changed = TrajectoryDataset(path)
    assert cache.stat().st_mtime_ns > written
    _assert_equal(changed[3], _segments([path], 16, 16)[3])
    cache.write_bytes(b"damaged")
    _assert_equal(TrajectoryDataset(path)[3], changed[3])


def test_copies_draw_for_themselves(folder: Path) -> None:
    dataset = TrajectoryDataset(folder)
    expected = dataset[[7, 300]]
    _assert_equal(pickle.loads(pickle.dumps(dataset))[[7, 300]], expected)
    child = os.fork()
    if child == 0:
        try:
            _assert_equal(dataset[[7, 300]], expected)
            os._exit(0)
        finally:
            os._exit(1)
    assert os.waitpid(child, 0)[1] == 0
    _assert_equal(dataset[[7, 300]], expected)
    dataset.close()


@pytest.mark.parametrize("workers", [0, 2])
def test_pytorch_reads_every_segment_once(folder: Path, workers: int) -> None:
    torch = pytest.importorskip("torch")
    dataset = TrajectoryDataset(folder, 32)
    loader = torch.utils.data.DataLoader(dataset, batch_size=40, shuffle=True, num_workers=workers)
    sums: list[int] = []
    for batch in loader:
        assert batch["observations"].shape[1:] == (32, 64, 64, 3)
        assert batch["actions"].dtype == torch.int64
        sums += batch["observations"].sum(dim=(1, 2, 3, 4)).tolist()
    expected = [int(each["observations"].sum()) for each in _segments(dataset.paths, 32, 32)]
    assert sorted(sums) == sorted(expected)
    dataset.close()


def test_larger_frames(folder: Path) -> None:
    dataset = TrajectoryDataset(folder, 4, screen_size=80, layout="chw")
    assert dataset[0]["observations"].shape == (4, 3, 80, 80)
    dataset.close()


def test_wrong_arguments_are_errors(folder: Path) -> None:
    for name in ("segment_length", "stride", "snapshot_interval"):
        with pytest.raises(errors.InvalidArgumentError, match=f"{name} is 0; it is in"):
            TrajectoryDataset(folder, **{name: 0})
    with pytest.raises(errors.InvalidArgumentError, match="is 129; the environments have 128"):
        TrajectoryDataset(folder, 129)
    with pytest.raises(errors.NotFoundError):
        TrajectoryDataset(folder / "none")
    dataset = TrajectoryDataset(folder, 128)
    assert len(dataset) == 71
    for index in (71, -72):
        with pytest.raises(IndexError, match="there are 71 segments"):
            dataset[index]
    with pytest.raises(errors.InvalidArgumentError, match="drawing has no option 'frame_stack'"):
        TrajectoryDataset(folder, frame_stack=4)[0]
