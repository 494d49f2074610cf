"""Minari and WebDataset read expansions; a data set of Procgen 0.10.7 is expanded equal."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from small_recordings import recorded

_BENCHMARK = Path(__file__).resolve().parents[3] / "benchmark"
_MINARI = """
import sys
import minari, numpy as np
from procgen_client.dataset import load
from procgen_client.dataset.expansion import Expansion, Replay, expand, finish, prepare
from small_recordings import Frames
from procgen_client.dataset import replay
from pathlib import Path

paths, output = list(map(Path, sys.argv[2:])), Path(sys.argv[1])
for _ in range(2):  # The second time, nothing is missing.
    expansion = Expansion("minari", output)
    prepare(paths, expansion)
    for path in paths:
        expand(Replay(path, expansion))
    finish(paths, expansion)
dataset = minari.MinariDataset(output / "bigfish/data")
assert dataset.observation_space.shape == (64, 64, 3) and dataset.action_space.n == 15
all_trajectories = list(map(load, paths))
assert dataset.total_steps == sum(each.actions.size for each in all_trajectories)
episodes, final_frames_differ = iter(dataset.iterate_episodes()), 0
for trajectories in all_trajectories:
    frames = Frames()
    replay(trajectories, "", writer=frames)
    for env in range(trajectories.header.env_count):
        first = 0
        while first < trajectories.header.step_count:
            episode = next(episodes)
            end = first + len(episode.actions)
            np.testing.assert_array_equal(episode.observations[:-1], frames.all[env, first:end])
            np.testing.assert_array_equal(episode.actions, trajectories.actions[env, first:end])
            np.testing.assert_array_equal(episode.rewards, trajectories.rewards[env, first:end])
            ended = trajectories.ended[env, first:end]
            assert not ended[:-1].any()
            assert episode.terminations.sum() == trajectories.terminated[env, end - 1]
            assert episode.terminations[-1] != episode.truncations[-1]
            assert len(episode.infos["level_seed"]) == len(episode.actions) + 1
            if ended[-1]:  # Not the first frame of the next episode.
                final_frames_differ += (episode.observations[-1] != frames.all[env, end]).any()
            else:
                assert end == trajectories.header.step_count
                np.testing.assert_array_equal(episode.observations[-1], frames.all[env, end])
            first = end
assert next(episodes, None) is None
assert final_frames_differ > 10
assert len(dataset.sample_episodes(3)) == 3
"""
_WEBDATASET = """
import sys
import numpy as np, webdataset
from procgen_client.dataset import TrajectoryDataset

dataset = TrajectoryDataset(sys.argv[1], 64)
shards = sorted(sys.argv[2:])
samples = list(webdataset.WebDataset(shards, shardshuffle=False).decode())
assert len(samples) == len(dataset)
for sample in samples:
    name, step, env = sample["__key__"].rsplit("-", 2)
    index = (64 * int(name[8:13]) + int(env)) * 3 + int(step) // 64
    for each, array in dataset[index].items():
        np.testing.assert_array_equal(sample[f"{each}.npy"], array)
"""
_UPSTREAM = """
import sys
from pathlib import Path
import numpy as np
from libenv_environments import LibenvEnvironments
from procgen_client.dataset import from_actions, replay
from small_recordings import Frames

package = Path(sys.argv[1])
images = package / "data/assets"
for game in ("coinrun", "bigfish", "ninja", "maze"):
    environments = LibenvEnvironments(package / "data/prebuilt/libenv.so", images, game)
    actions = np.random.default_rng(1).integers(0, 15, (200, 64), np.int32)
    recorded = [environments.step(row).copy() for row in actions]  # A loop of upstream's own.
    trajectories = from_actions(game, actions.T, art=images, rand_seed=1, distribution_mode="easy")
    trajectories.save(f"{game}.trajectories.npz")
    frames = Frames()
    replay(trajectories, game, art=images, writer=frames)
    np.testing.assert_array_equal(frames.all[:, 1:].swapaxes(0, 1), recorded)
"""


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The interpreter of an environment with the other libraries."""
    folder = tmp_path_factory.mktemp("packages")
    subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    packages = ("h5py", "minari", "webdataset", "Pillow", "numpy")
    subprocess.run([folder / "bin/pip", "install", "--quiet", *packages], check=True)
    return folder / "bin/python"


def _run(python: Path, program: str, *arguments: str | Path, folder: Path) -> None:
    paths = (os.environ["PYTHONPATH"], Path(__file__).parent, _BENCHMARK)
    run = subprocess.run(
        [python, "-c", program, *arguments],
        env={**os.environ, "PYTHONPATH": ":".join(map(str, paths))},
        capture_output=True,
        text=True,
        check=False,
        cwd=folder,
    )
    assert run.returncode == 0, run.stderr


def test_minari_reads_episodes(python: Path, tmp_path: Path) -> None:
    files = recorded(tmp_path / "data", env_count=66, step_count=66 * 150)
    _run(python, _MINARI, tmp_path / "frames", *files, folder=tmp_path)


def test_webdataset_reads_segments(python: Path, tmp_path: Path) -> None:
    recorded(tmp_path / "data", env_count=66, step_count=66 * 150)
    subprocess.run(
        [sys.executable, "-m", "procgen_client.dataset", "replay", tmp_path / "data",
         "--format", "webdataset", "--output", tmp_path / "frames"],
        check=True, capture_output=True,
    )  # fmt: skip
    shards = (tmp_path / "frames").glob("*.tar")
    _run(python, _WEBDATASET, tmp_path / "data", *shards, folder=tmp_path)


def test_recording_of_the_package_procgen_is_expanded_equal(python: Path, tmp_path: Path) -> None:
    subprocess.run(
        [python, "-m", "pip", "install", "--quiet", "--no-deps", "--only-binary=:all:",
         "--python-version=3.10", "--platform=manylinux2014_x86_64", "--target", tmp_path,
         "procgen==0.10.7"],
        check=True,
    )  # fmt: skip
    _run(python, _UPSTREAM, tmp_path / "procgen", folder=tmp_path)
