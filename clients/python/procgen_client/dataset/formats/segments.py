"""Segments: equally long pieces of an environment's steps, as .npz files or tar files.

Row t of a segment is an observation, the action in it, and the reward and end to which it led. An
episode may end within a segment; `first` is true where the next one begins.
"""

from __future__ import annotations

import functools
import io
import tarfile
import zipfile
from collections.abc import Iterator, Sequence
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
        self,
        file: IO[bytes],
        key: str,
        shape: tuple[int, ...],
        frames: Iterator[memoryview],
        scalars: dict[str, np.ndarray],
    ) -> None:
        """Writes a file.

        Args:
            file: Receives it.
            key: Name of the trajectories, and the first step.
            shape: Of all observations, [N, n, *F].
            frames: Observations of each environment. Each is valid until the next.
            scalars: The other arrays, [N, n].
        """
        raise NotImplementedError


class NpzSegments(_Segments):
    """Archives of numpy, not compressed: observations uint8 [N, n, *F], the others [N, n]."""

    suffix = ".npz"

    def save(
        self,
        file: IO[bytes],
        key: str,
        shape: tuple[int, ...],
        frames: Iterator[memoryview],
        scalars: dict[str, np.ndarray],
    ) -> None:
        """Writes a file; see _Segments. As numpy.savez, with fewer copies."""
        with zipfile.ZipFile(file, "w") as archive:
            with archive.open("observations.npy", "w", force_zip64=True) as member:
                member.write(_npy_header(np.dtype(np.uint8), shape))
                for each in frames:
                    member.write(each)
            for name, array in scalars.items():
                archive.writestr(zipfile.ZipInfo(f"{name}.npy"), _npy(array))


class WebDataset(_Segments):
    """Tar files of WebDataset: a sample is a segment, with a .npy file for each array.

    Not PNG: to decode one takes longer than to draw the frame.
    """

    suffix = ".tar"

    def save(
        self,
        file: IO[bytes],
        key: str,
        shape: tuple[int, ...],
        frames: Iterator[memoryview],
        scalars: dict[str, np.ndarray],
    ) -> None:
        """Writes a file; see _Segments."""
        for env, each in enumerate(frames):
            name = f"{key}-{env:02d}"
            header = _npy_header(np.dtype(np.uint8), shape[1:])
            size = len(header) + each.nbytes
            file.write(_tar_header(f"{name}.observations.npy", size) + header)
            file.write(each)
            file.write(_padding(size))
            for array_name, array in scalars.items():
                data = _npy(array[env])
                start = _tar_header(f"{name}.{array_name}.npy", len(data))
                file.write(start + data + _padding(len(data)))
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
        self._memory = np.empty(0, np.uint8)

    def write(self, block: Block) -> None:
        """Writes the file of a block."""
        assert block.observations is not None
        steps = slice(block.start, block.start + block.step_count)
        scalars = {each: array[:, steps] for each, array in self._scalars.items()}
        observations = block.observations[: block.step_count].swapaxes(0, 1)
        key = f"{self._name}-{block.start:08d}"
        write_atomically(
            self._paths[block.start // self.block_length],
            lambda file: self._segments.save(
                file, key, observations.shape, self._contiguous(observations), scalars
            ),
        )

    def _contiguous(self, observations: np.ndarray) -> Iterator[memoryview]:
        """Yields the observations of each environment in the same memory."""
        if self._memory.shape != observations.shape[1:]:
            self._memory = np.empty(observations.shape[1:], np.uint8)
        for each in observations:
            self._memory[:] = each
            yield self._memory.data


def _npy(array: np.ndarray) -> bytes:
    return _npy_header(array.dtype, array.shape) + array.tobytes()


@functools.lru_cache(64)
def _npy_header(dtype: np.dtype, shape: tuple[int, ...]) -> bytes:
    """Returns the beginning of a .npy file."""
    header = io.BytesIO()
    npy: Any = np.lib.format  # Without types.
    fields = {"descr": npy.dtype_to_descr(dtype), "fortran_order": False, "shape": shape}
    npy.write_array_header_1_0(header, fields)
    return header.getvalue()


def _tar_header(name: str, size: int) -> bytes:
    """As TarInfo.tobuf, which takes as long as 20 frames."""
    header = bytearray(_tar_template(size))
    header[: len(name)] = name.encode("ascii")
    header[148:156] = b"        "
    header[148:156] = b"%06o\0 " % sum(header)
    return bytes(header)


@functools.lru_cache(64)
def _tar_template(size: int) -> bytes:
    info = tarfile.TarInfo()
    info.size = size
    return info.tobuf(tarfile.USTAR_FORMAT)


def _padding(size: int) -> bytes:
    return bytes(-size % tarfile.BLOCKSIZE)
