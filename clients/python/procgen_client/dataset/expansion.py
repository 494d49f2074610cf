"""Expansions: the frames of trajectory files, drawn again, in a format of other libraries."""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Optional

from procgen_client._checkpoint import write_atomically
from procgen_client.dataset.formats import format_of
from procgen_client.dataset.play import Report, replay
from procgen_client.dataset.trajectories import SUFFIX, load
from procgen_client.errors import InvalidArgumentError


class Expansion(NamedTuple):
    """What becomes of some trajectory files."""

    format: Optional[str] = None  # One of formats.FORMATS. None: they are only compared.
    folder: Path = Path()  # Receives the files of the format.
    segment_length: int = 64  # As for formats.format_of.
    art: Optional[str] = None  # None: the recorded one.
    drawing: Mapping[str, Any] = {}  # As for play.play.


class Replay(NamedTuple):
    """A trajectory file to be replayed."""

    path: Path
    expansion: Expansion


def expand(job: Replay, report: Report = lambda _: None) -> None:
    """Replays a file, compares rewards, ends, levels and digests of frames, and writes the frames.

    The folder is that of :func:`prepare`.

    Files of the format that are complete are not written again, unless some of them are missing.

    Raises:
        DataLossError: The file is damaged, or its replay differs.
        OSError: A file cannot be read or written.
        ProcgenError: As Pool.
    """
    trajectories = load(job.path)
    expansion = job.expansion
    writer = None
    if expansion.format is not None:
        files = format_of(expansion.format, expansion.segment_length)
        name = name_of(job.path)
        if all((expansion.folder / file).exists() for file in files.files(name, trajectories)):
            report(trajectories.actions.size)
            return
        writer = files.writer(expansion.folder, name, trajectories)
    replay(
        trajectories, str(job.path), art=expansion.art, drawing=expansion.drawing, writer=writer,
        report=report, num_threads=0,
    )  # fmt: skip


def finish(paths: Sequence[Path], expansion: Expansion) -> None:
    """Writes what all files of the format have in common, after each was expanded."""
    if expansion.format is not None:
        files = format_of(expansion.format, expansion.segment_length)
        files.finish(expansion.folder, [(name_of(path), path) for path in paths])


def prepare(paths: Sequence[Path], expansion: Expansion) -> None:
    """Makes the folder of an expansion, and notes there what it is of.

    Raises:
        InvalidArgumentError: It has another expansion, of other files of the same names, or in
            another format; or two files have the same name.
        OSError: A file cannot be read or written.
    """
    if expansion.format is None:
        return
    names: dict[str, Path] = {}
    for path in paths:
        other = names.setdefault(name_of(path), path)
        if other is not path:
            raise InvalidArgumentError(
                f"{other} and {path} have the same name: expand them into different folders"
            )
    settings: dict[str, Any] = {
        "format": expansion.format,
        "segment_length": expansion.segment_length,
        "art": expansion.art,
        **expansion.drawing,
    }
    note = expansion.folder / "expansion.json"
    checksums = {name: zlib.crc32(path.read_bytes()) for name, path in names.items()}
    if note.exists():
        noted = json.loads(note.read_text())
        for name, checksum in noted.pop("files").items():
            if checksums.setdefault(name, checksum) != checksum:
                raise InvalidArgumentError(
                    f"{expansion.folder} has frames of another {name}: choose another folder"
                )
        if noted != settings:
            raise InvalidArgumentError(
                f"{expansion.folder} has an expansion with {noted}, not with {settings}: choose "
                "another folder"
            )
    expansion.folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps({**settings, "files": checksums}, indent=1).encode()
    write_atomically(note, lambda file: file.write(text))


def name_of(path: Path) -> str:
    """Returns the name of a trajectory file without its suffix."""
    name = path.name
    return name[: -len(SUFFIX)] if name.endswith(SUFFIX) else path.stem
