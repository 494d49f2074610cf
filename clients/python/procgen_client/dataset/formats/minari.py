"""Minari's layout: an HDF5 file of episodes for each part, and one that links them, per game."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from procgen_client._checkpoint import write_atomically
from procgen_client._requests import ACTION_COUNT
from procgen_client.dataset.play import Block, Writer
from procgen_client.dataset.trajectories import Trajectories, load
from procgen_client.errors import InvalidArgumentError

# The oldest version of Minari with uncompressed images.
_MINARI_VERSION = "0.5.4"


class Minari:
    """A Minari data set of each game: ``MinariDataset("FOLDER/coinrun/data")``.

    An episode has its last observation, too. The last episode of each environment, which the
    recording cuts, is truncated.
    """

    def __init__(self) -> None:
        """Requires h5py.

        Raises:
            InvalidArgumentError: It is not installed.
        """
        try:
            import h5py  # noqa: F401
        except ImportError:
            raise InvalidArgumentError(
                "the format minari needs h5py, which is not installed: pip install h5py"
            ) from None

    def files(self, name: str, trajectories: Trajectories) -> Sequence[Path]:
        """Returns the file of some trajectories."""
        return [_folder(trajectories) / f"{name}.hdf5"]

    def writer(self, folder: Path, name: str, trajectories: Trajectories) -> Writer:
        """Returns what writes it."""
        return _MinariWriter(folder / self.files(name, trajectories)[0], trajectories)

    def finish(self, folder: Path, parts: Sequence[tuple[str, Path]]) -> None:
        """Writes the file that links the episodes, and the metadata, of each game."""
        by_folder: dict[Path, list[tuple[str, Trajectories]]] = {}
        for name, path in parts:
            trajectories = load(path)
            by_folder.setdefault(folder / _folder(trajectories), []).append((name, trajectories))
        for data, named in by_folder.items():
            _link(data, named)


class _MinariWriter:
    block_length = 64
    needs_final_observations = True

    def __init__(self, path: Path, trajectories: Trajectories) -> None:
        import h5py

        path.parent.mkdir(parents=True, exist_ok=True)
        self._path = path
        self._part = path.with_name(f"{path.name}.part")
        self._file = h5py.File(self._part, "w")
        self._step_count = trajectories.header.step_count
        # The episodes of each environment, in order: first step, end, dataset of observations.
        self._episodes: list[list[tuple[int, int, Any]]] = [
            [] for _ in range(trajectories.header.env_count)
        ]
        self._trajectories = trajectories

    def write(self, block: Block) -> None:
        """Writes the observations of a block; the last one publishes the file."""
        assert block.observations is not None
        if not self._episodes[0]:
            self._create(block.observations.shape[2:])
        end = block.start + block.step_count
        for env, episodes in enumerate(self._episodes):
            while episodes and episodes[0][0] < end:
                first, last, dataset = episodes[0]
                begin, stop = max(first, block.start), min(last, end)
                rows = slice(begin - block.start, stop - block.start)
                dataset[begin - first : stop - first] = block.observations[rows, env]
                if last > end:
                    break
                final = block.final_observations.get((last - 1 - block.start, env))
                # Of a cut episode: the next observation.
                dataset[last - first] = (
                    block.observations[block.step_count, env] if final is None else final
                )
                del episodes[0]
        if end == self._step_count:
            self._file.close()
            with open(self._part, "rb") as file:
                os.fsync(file.fileno())
            os.replace(self._part, self._path)

    def _create(self, shape: tuple[int, ...]) -> None:
        """Creates the groups of all episodes, with everything but the observations."""
        trajectories = self._trajectories
        for i, (env, first, last) in enumerate(_episodes_of(trajectories)):
            group = self._file.create_group(f"episode_{i}")
            steps = slice(first, last)
            truncations = trajectories.truncated[env, steps].copy()
            truncations[-1] |= not trajectories.terminated[env, last - 1]
            group.attrs["total_steps"] = last - first
            group["actions"] = trajectories.actions[env, steps].astype(np.int64)
            group["rewards"] = trajectories.rewards[env, steps]
            group["terminations"] = trajectories.terminated[env, steps]
            group["truncations"] = truncations
            group["infos/level_seed"] = trajectories.level_seeds[env, first : last + 1]
            size = (last - first + 1, *shape)
            self._episodes[env].append(
                (first, last, group.create_dataset("observations", size, np.uint8))
            )


def _folder(trajectories: Trajectories) -> Path:
    return Path(trajectories.header.game) / "data"


def _episodes_of(trajectories: Trajectories) -> Iterator[tuple[int, int, int]]:
    """Yields environment, first step and end of all episodes."""
    step_count = trajectories.header.step_count
    for env, ended in enumerate(trajectories.ended):
        first = 0
        for last in [*(np.flatnonzero(ended) + 1).tolist(), step_count]:
            if last > first:
                yield env, first, last
            first = last


def _link(folder: Path, parts: Sequence[tuple[str, Trajectories]]) -> None:
    import h5py

    count = 0
    part = folder / "main_data.hdf5.part"
    with h5py.File(part, "w") as file:
        for name, trajectories in parts:
            for i, _ in enumerate(_episodes_of(trajectories)):
                file[f"episode_{count}"] = h5py.ExternalLink(f"{name}.hdf5", f"episode_{i}")
                count += 1
        shape = file["episode_0/observations"].shape[1:]
    os.replace(part, folder / "main_data.hdf5")
    header = parts[0][1].header
    space = {
        "type": "Box", "dtype": "uint8", "shape": list(shape),
        "low": np.zeros(shape, int).tolist(), "high": np.full(shape, 255).tolist(),
    }  # fmt: skip
    metadata = {
        "dataset_id": f"procgen/{header.game}-v0",
        "total_episodes": count,
        "total_steps": sum(each.actions.size for _, each in parts),
        "data_format": "hdf5",
        "jpeg_encoding": False,
        "observation_space": json.dumps(space),
        "action_space": json.dumps(
            {"type": "Discrete", "dtype": "int64", "start": 0, "n": ACTION_COUNT}
        ),
        "minari_version": _MINARI_VERSION,
        "algorithm_name": header.policy,
        "description": f"{header.game} of Procgen; options: {json.dumps(header.options)}",
    }
    text = json.dumps(metadata).encode()
    write_atomically(folder / "metadata.json", lambda file: file.write(text))
