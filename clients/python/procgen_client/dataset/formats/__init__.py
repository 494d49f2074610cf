"""Formats of frames: files that other libraries read."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from procgen_client.dataset.formats.minari import Minari
from procgen_client.dataset.formats.segments import NpzSegments, WebDataset
from procgen_client.dataset.play import Writer
from procgen_client.dataset.trajectories import Trajectories
from procgen_client.errors import InvalidArgumentError


class Format(Protocol):
    """A format. Each file appears when it is complete, so that a replay can be repeated."""

    def files(self, name: str, trajectories: Trajectories) -> Sequence[Path]:
        """Returns the files of some trajectories, relative to the folder of all."""

    def writer(self, folder: Path, name: str, trajectories: Trajectories) -> Writer:
        """Returns what writes these files."""

    def finish(self, folder: Path, parts: Sequence[tuple[str, Path]]) -> None:
        """Writes what all parts have in common; (name, trajectory file) of each."""


FORMATS = ("npz", "webdataset", "minari")


def format_of(name: str, segment_length: int = 64) -> Format:
    """Returns a format.

    Args:
        name: One of FORMATS.
        segment_length: Steps of a segment; Minari has episodes instead.

    Raises:
        InvalidArgumentError: There is no such format, its package is missing, or the length is
            less than 1.
    """
    if segment_length < 1:
        raise InvalidArgumentError(f"segment_length is {segment_length}; it is at least 1")
    if name == "npz":
        return NpzSegments(segment_length)
    if name == "webdataset":
        return WebDataset(segment_length)
    if name == "minari":
        return Minari()
    raise InvalidArgumentError(f"format is {name!r}; it is one of {', '.join(FORMATS)}")
