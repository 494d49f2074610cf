"""Segments: equally long pieces of an environment's steps, as .npz files or tar files.

Row t of a segment is an observation, the action in it, and the reward and end to which it led. An
episode may end within a segment; `first` is true where the next one begins.
"""

from __future__ import annotations

import io
import tarfile
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any

import numpy as np

from procgen_client._checkpoint import write_atomically
from procgen_client.dataset.play import Block, Writer
from procgen_client.dataset.trajectories import Trajectories

_SCALARS = ("actions", "rewards", "terminated", "truncated", "first", "level_seeds")


class _Segments:
    """A format with a file for each block: the segments of all environments at the same steps."""

    suffix = ""

    def __init__(self, segment_length: int) -> None:
        """Takes the number of steps in a segment; the last one may have fewer."""
        self.block_length = segment_length

    def files(self, name: str, trajectories: Trajectories) -> Sequence[Path]:
        """Returns the files of some trajectories."""
        count = -(-trajectories.header.step_count // self.block_length)
        return [Path(f"{name}-{i:06d}{self.suffix}") for i in range(count)]

    def writer(self, folder: Path, name: str, trajectories: Trajectories) -> Writer:
        """Returns what writes these files."""
        return _SegmentWriter(self, folder, name, trajectories)

    def finish(self, folder: Path, parts: Sequence[tuple[str, Path]]) -> None:
        """Does nothing."""

    def save(
        self, file: IO[bytes], observations: np.ndarray, scalars: dict[str, np.ndarray], key: str
    ) -> None:
        """Writes a file.

        Args:
            file: Receives it.
            observations: uint8 [n, N, *F], in order of time.
            scalars: The other arrays, [N, n].
            key: Game and first environment, and the first step.
        """
        raise NotImplementedError


class NpzSegments(_Segments):
    """Archives of numpy, not compressed: observations uint8 [N, n, *F], the others [N, n]."""

    suffix = ".npz"

    def save(
        self, file: IO[bytes], observations: np.ndarray, scalars: dict[str, np.ndarray], key: str
    ) -> None:
        """Writes a file; see _Segments."""
        np.savez(file, observations=np.ascontiguousarray(observations.swapaxes(0, 1)), **scalars)


class WebDataset(_Segments):
    """Tar files of WebDataset: a sample is a segment, with a .npy file for each array.

    Not PNG: to decode one takes longer than to draw the frame.
    """

    suffix = ".tar"

    def save(
        self, file: IO[bytes], observations: np.ndarray, scalars: dict[str, np.ndarray], key: str
    ) -> None:
        """Writes a file; see _Segments."""
        for env in range(observations.shape[1]):
            arrays = {"observations": observations[:, env]}
            arrays |= {name: array[env] for name, array in scalars.items()}
            for name, array in arrays.items():
                _add(file, f"{key}-{env:02d}.{name}.npy", np.ascontiguousarray(array))
        file.write(bytes(2 * tarfile.BLOCKSIZE))


class _SegmentWriter:
    needs_final_observations = False

    def __init__(
        self, segments: _Segments, folder: Path, name: str, trajectories: Trajectories
    ) -> None:
        self.block_length = segments.block_length
        self._segments = segments
        self._name = name
        self._paths = [folder / file for file in segments.files(name, trajectories)]
        self._scalars = {each: getattr(trajectories, each) for each in _SCALARS}

    def write(self, block: Block) -> None:
        """Writes the file of a block."""
        assert block.observations is not None
        steps = slice(block.start, block.start + block.step_count)
        scalars = {each: array[:, steps] for each, array in self._scalars.items()}
        observations = block.observations[: block.step_count]
        key = f"{self._name}-{block.start:08d}"
        write_atomically(
            self._paths[block.start // self.block_length],
            lambda file: self._segments.save(file, observations, scalars, key),
        )


def _add(file: IO[bytes], name: str, array: np.ndarray) -> None:
    """Adds an array to a tar file; tarfile would copy it."""
    header = io.BytesIO()
    npy: Any = np.lib.format  # Without types.
    npy.write_array_header_1_0(header, npy.header_data_from_array_1_0(array))
    info = tarfile.TarInfo(name)
    info.size = header.tell() + array.nbytes
    file.write(info.tobuf(tarfile.USTAR_FORMAT))
    file.write(header.getvalue())
    file.write(array.data)
    file.write(bytes(-info.size % tarfile.BLOCKSIZE))
