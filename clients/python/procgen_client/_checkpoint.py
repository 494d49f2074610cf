"""Checkpoints: a file with the snapshots of a pool and the state of the environment around it.

The file is a .npz archive of numpy, without pickles: `header` (JSON), `ended` (bool [N]),
`snapshots` (uint8, one after the other) and `sizes` (int64 [N], in bytes).
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np

from procgen_client.errors import DataLossError, InvalidArgumentError
from procgen_client.pool import Pool

_FORMAT = "procgen_client checkpoint"
_VERSION = 1


class WrapperState(NamedTuple):
    """The state of an environment that is not in its snapshots."""

    ended: np.ndarray  # The last step ended the episode, and the next has not started  bool [N]
    untouched: bool = False  # Neither reset nor stepped.
    next_levels: dict[int, int] = {}  # Level seeds by environment, to be sent with the next step.


def save(path: str | os.PathLike[str], pool: Pool, state: WrapperState) -> None:
    """Writes a checkpoint; a failure leaves the file at `path` as it was.

    Raises:
        OSError: The file cannot be written.
        ProcgenError: As Pool.save_states.
    """
    snapshots = pool.save_states()
    header = _identity(pool) | {
        "untouched": state.untouched,
        "next_levels": [[int(i), int(seed)] for i, seed in state.next_levels.items()],
    }
    arrays = {
        "header": np.frombuffer(json.dumps(header).encode(), np.uint8),
        "ended": state.ended,
        "snapshots": np.frombuffer(b"".join(snapshots), np.uint8),
        "sizes": np.array([len(snapshot) for snapshot in snapshots], np.int64),
    }
    write_atomically(Path(path), lambda file: np.savez(file, **arrays))


def load(path: str | os.PathLike[str], pool: Pool) -> WrapperState:
    """Restores the pool from a checkpoint, and returns the rest of its state.

    Raises:
        OSError: The file cannot be read.
        DataLossError: The file is damaged, truncated, or of another version.
        InvalidArgumentError: It is of other games, another number of environments or another
            autoreset mode. Nothing was restored.
        ProcgenError: As Pool.restore_states.
    """
    with open(path, "rb") as file:
        try:
            header, arrays = _read(file)
        except Exception as error:  # What numpy and zipfile raise depends on the damage.
            raise DataLossError(
                f"{path} is not a checkpoint, or is damaged or truncated: {error}"
            ) from None
    if header["version"] != _VERSION:
        raise DataLossError(
            f"{path} has version {header['version']} of the format; this program reads {_VERSION}"
        )
    for name, expected in _identity(pool).items():
        if header[name] != expected:
            raise InvalidArgumentError(
                f"{path} has {name} {header[name]}; this environment has {expected}"
            )
    ends = np.cumsum(arrays["sizes"])
    data = arrays["snapshots"].tobytes()
    starts = ends - arrays["sizes"]
    pool.restore_states([data[start:end] for start, end in zip(starts, ends)])
    return WrapperState(
        arrays["ended"], header["untouched"], {i: seed for i, seed in header["next_levels"]}
    )


def write_atomically(path: Path, write: Callable[[IO[bytes]], object]) -> None:
    """Writes a temporary file beside `path`, syncs it, and renames it to `path`."""
    part = path.with_name(f"{path.name}.part")
    try:
        with open(part, "wb") as file:
            write(file)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def _identity(pool: Pool) -> dict[str, Any]:
    """Returns what a checkpoint and the pool that loads it have in common."""
    return {
        "format": _FORMAT,
        "version": _VERSION,
        "games": list(pool.games),
        "env_count": pool.env_count,
        "autoreset_mode": pool.autoreset_mode,
    }


def _read(file: IO[bytes]) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Returns the header and the arrays. Raises any Exception for a damaged file."""
    with np.load(file, allow_pickle=False) as archive:
        arrays = {name: archive[name] for name in archive.files}
    header = json.loads(arrays["header"].tobytes())
    if header["format"] != _FORMAT:
        raise ValueError(f"its format is {header['format']!r}")
    if arrays["sizes"].sum() != arrays["snapshots"].size:
        raise ValueError("its snapshots are incomplete")
    return header, arrays
