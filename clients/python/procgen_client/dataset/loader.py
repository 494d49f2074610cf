"""A data set for PyTorch whose frames are drawn when they are read."""

from __future__ import annotations

import bisect
import multiprocessing
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Union

import numpy as np

from procgen_client._requests import in_range
from procgen_client.dataset.play import open_pool, recorded_art
from procgen_client.dataset.snapshots import Snapshots, snapshots_of
from procgen_client.dataset.trajectories import Header, Trajectories, find, load
from procgen_client.errors import InvalidArgumentError
from procgen_client.pool import Pool
from procgen_client.tools.art import Art

Sample = dict[str, np.ndarray]

_SCALARS = ("actions", "rewards", "terminated", "truncated", "first", "level_seeds")


class TrajectoryDataset:
    """Segments of trajectory files, in any order: a map-style data set of PyTorch.

    A sample is a dict of arrays; row t is an observation, the action in it, and the reward and end
    to which it led. An episode may end within a segment; `first` is true where the next begins::

        dataset = TrajectoryDataset("data", segment_length=16)
        for batch in torch.utils.data.DataLoader(dataset, batch_size=64, shuffle=True):
            train(batch["observations"], batch["actions"])

    ==============  ========================  =====================================================
    observations    uint8   [L, 64, 64, 3]    or as the drawing options say
    actions         int64   [L]               in [-1, 15)
    rewards         float32 [L]
    terminated      bool    [L]               the game ended the episode
    truncated       bool    [L]               the time limit ended the episode
    first           bool    [L]               the observation is the first of an episode
    level_seeds     int32   [L]               level in the observation
    ==============  ========================  =====================================================

    A batch is drawn at once: ``dataset[[3, 1, 4]]`` is a dict of arrays with an axis more, and
    DataLoader calls :meth:`__getitems__`. Threads: one at a time. Processes: each draws for itself;
    a copy that DataLoader forks or pickles is complete.

    PyTorch is not required.
    """

    def __init__(
        self,
        paths: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
        segment_length: int = 16,
        *,
        stride: int | None = None,
        snapshot_interval: int = 64,
        art: Art | None = None,
        num_threads: int | None = None,
        **drawing: Any,  # noqa: ANN401
    ) -> None:
        """Reads the files, and makes snapshots where none are kept: see dataset.snapshots.

        Args:
            paths: Trajectory files and folders.
            segment_length: Number of steps in a sample, L.
            stride: Steps from the beginning of a segment to that of the next. None: L.
            snapshot_interval: Steps from one snapshot to the next: a smaller one draws sooner and
                needs more memory, about 500 bytes for each snapshot.
            art: As for Pool; None: the recorded one.
            num_threads: As for Pool. None: all cores, in a child process one.
            **drawing: screen_size, grayscale_obs and layout, as for Pool.

        Raises:
            InvalidArgumentError: A number is out of range, or no environment has so many steps.
            NotFoundError: There are no such files.
            DataLossError: A file is damaged.
            ProcgenError: As Pool.
        """
        self.segment_length = in_range("segment_length", segment_length, 1, 2**31 - 1)
        self.stride = in_range("stride", segment_length if stride is None else stride, 1, 2**31 - 1)
        interval = in_range("snapshot_interval", snapshot_interval, 1, 2**31 - 1)
        self._art, self._drawing, self._num_threads = art, drawing, num_threads
        given = [paths] if isinstance(paths, (str, os.PathLike)) else list(paths)
        self.paths: list[Path] = find(map(Path, given))
        self._files: list[tuple[Trajectories, np.ndarray, Snapshots]] = []
        self._ends: list[int] = []  # Number of samples up to the end of each file.
        self._pools: dict[tuple[str, str | None], Pool] = {}  # By game and art.
        self._process_id = os.getpid()
        count = 0
        for path in self.paths:
            trajectories = load(path)
            if art is None:
                recorded_art(trajectories.header)  # Fails if it is unknown.
            self._files.append(
                (trajectories, trajectories.first, snapshots_of(path, trajectories, interval))
            )
            count += self._segments(trajectories.header) * trajectories.header.env_count
            self._ends.append(count)
        if not count:
            raise InvalidArgumentError(
                f"segment_length is {segment_length}; the environments have "
                f"{max(each.header.step_count for each, _, _ in self._files)} steps"
            )

    def __len__(self) -> int:
        """Returns the number of segments."""
        return self._ends[-1]

    def __getitem__(self, index: Union[int, Sequence[int], np.ndarray]) -> Sample:
        """Returns a sample; of a list of indices, all samples along a first axis."""
        if isinstance(index, (int, np.integer)):
            return {name: array[0] for name, array in self._batch([int(index)]).items()}
        return self._batch([int(each) for each in index])

    def __getitems__(self, indices: Sequence[int]) -> list[Sample]:
        """Returns samples, which are drawn at once: for DataLoader."""
        batch = self[indices]
        return [{name: array[i] for name, array in batch.items()} for i in range(len(indices))]

    def __getstate__(self) -> Mapping[str, Any]:
        """Supports pickle: everything but the pools."""
        return {**self.__dict__, "_pools": {}}

    def close(self) -> None:
        """Frees the environments. The next read makes them again."""
        pools, self._pools = self._pools, {}
        if os.getpid() == self._process_id:
            for pool in pools.values():
                pool.close()
        self._process_id = os.getpid()

    def _segments(self, header: Header) -> int:
        """Returns the number of segments of an environment."""
        return max(0, (header.step_count - self.segment_length) // self.stride + 1)

    def _batch(self, indices: list[int]) -> Sample:
        groups: dict[tuple[str, str | None], list[tuple[int, int, int, int]]] = {}
        for row, index in enumerate(indices):
            file, env, step = self._place(index)
            header = self._files[file][0].header
            groups.setdefault((header.game, header.art), []).append((row, file, env, step))
        batch: Sample = {}
        for key, rows in groups.items():
            self._read(key, rows, len(indices), batch)
        return batch

    def _place(self, index: int) -> tuple[int, int, int]:
        """Returns the file, the environment and the first step of a segment."""
        count = len(self)
        if not -count <= index < count:
            raise IndexError(f"index {index} is out of range; there are {count} segments")
        index %= count
        file = bisect.bisect_right(self._ends, index)
        index -= self._ends[file - 1] if file else 0
        env, segment = divmod(index, self._segments(self._files[file][0].header))
        return file, env, segment * self.stride

    def _read(
        self,
        key: tuple[str, str | None],
        rows: list[tuple[int, int, int, int]],
        batch_size: int,
        batch: Sample,
    ) -> None:
        """Draws segments of one game and art, and writes them into rows of a batch.

        Args:
            key: Game and art.
            rows: Row of the batch, file, environment and first step of each segment.
            batch_size: Number of rows of the batch.
            batch: The arrays; none before the first call.
        """
        # Those that are farthest from their snapshots are stepped first.
        interval = self._files[0][2].interval
        rows = sorted(rows, key=lambda each: -(each[3] % interval))
        offsets = np.array([step % interval for *_, step in rows])
        length = self.segment_length
        pool = self._pool(key, len(rows), self._files[rows[0][1]][0].header)
        states = {}
        ahead = np.zeros((int(offsets[0]) + length, len(rows)), np.int8)
        for i, (_, file, env, step) in enumerate(rows):
            trajectories, _, snapshots = self._files[file]
            states[i] = snapshots.at(step, env, trajectories.header.env_count)
            begin = step - int(offsets[i])
            ahead[offsets[0] - offsets[i] :, i] = trajectories.actions[env, begin : step + length]
        pool.restore_states(states)
        for t in range(int(offsets[0])):
            count = int(np.count_nonzero(offsets >= offsets[0] - t))
            pool.step(ahead[t, :count], env_count=count, observe=False)
        if "observations" not in batch:
            self._allocate(batch, batch_size, pool.observation_shape)
        order = np.array([row for row, *_ in rows])
        frames = pool.observe(env_count=len(rows)).observations
        batch["observations"][order, 0] = frames
        for t in range(1, length):
            pool.step(ahead[offsets[0] + t - 1], env_count=len(rows), out=frames)
            batch["observations"][order, t] = frames
        for row, file, env, step in rows:
            trajectories, first, _ = self._files[file]
            for name in _SCALARS:
                array = first if name == "first" else getattr(trajectories, name)
                batch[name][row] = array[env, step : step + length]

    def _allocate(self, batch: Sample, batch_size: int, shape: tuple[int, ...]) -> None:
        types = {"actions": np.int64, "rewards": np.float32, "level_seeds": np.int32}
        batch["observations"] = np.empty((batch_size, self.segment_length, *shape), np.uint8)
        for name in _SCALARS:
            batch[name] = np.empty((batch_size, self.segment_length), types.get(name, np.bool_))

    def _pool(self, key: tuple[str, str | None], env_count: int, header: Header) -> Pool:
        """Returns environments of a game, at least so many."""
        if os.getpid() != self._process_id:
            self.close()
        pool = self._pools.get(key)
        if pool is None or pool.env_count < env_count:
            if pool is not None:
                pool.close()
            threads = self._num_threads
            if threads is None and multiprocessing.parent_process() is not None:
                threads = 0
            one = Header(header.game, env_count, header.step_count, header.options)
            art = header.art if self._art is None else self._art
            pool = open_pool(one, art=art, drawing=self._drawing, num_threads=threads)
            self._pools[key] = pool
        return pool
