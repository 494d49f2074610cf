"""Trajectory files: what some environments of a game did, from which their frames can be drawn.

A file is a .npz archive of numpy, without pickles: `header` (JSON) and the arrays of
:class:`Trajectories`. It has half a byte per step, where the frames have 12,288.
"""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Union

import numpy as np

from procgen_client._checkpoint import write_atomically
from procgen_client._requests import ENV_COUNT_MAX, in_range
from procgen_client.errors import DataLossError, InvalidArgumentError, NotFoundError

SUFFIX = ".trajectories.npz"

_FORMAT = "procgen_client trajectories"
_VERSION = 1
# Element type of each array of a file, and the number of its columns less that of the steps.
# None: depends on the header.
_ARRAYS: dict[str, tuple[Any, Union[int, None]]] = {
    "actions": (np.int8, 0),
    "rewards": (np.float32, 0),
    "terminated": (np.bool_, 0),
    "truncated": (np.bool_, 0),
    "prev_level_complete": (np.bool_, 0),
    "level_seeds": (np.int32, 1),
    "frame_digests": (np.uint32, None),
}


@dataclasses.dataclass(frozen=True)
class Header:
    """What trajectories depend on beside their actions, and where they come from."""

    game: str
    env_count: int  # Number of environments, N.
    step_count: int  # Steps of each environment, T.
    options: dict[str, Any]  # Of options.EnvironmentOptions; has a rand_seed.
    first_env: int = 0  # The environments are a slice of a larger set: as of a Pool.
    total_env_count: int = 0
    art: str | None = None  # With which the digests were made; None: the project's own.
    policy: str = ""  # What chose the actions; for people.
    digest_interval: int = 64  # Steps from one digest of frames to the next.
    engine: str = ""  # Version of the engine that wrote the file.

    def __post_init__(self) -> None:
        """Raises InvalidArgumentError for a number that is out of range."""
        for name in ("env_count", "step_count", "digest_interval"):
            in_range(name, getattr(self, name), 1, ENV_COUNT_MAX)

    @property
    def digest_count(self) -> int:
        """Number of steps whose frames have a digest."""
        return self.step_count // self.digest_interval + 1


@dataclasses.dataclass(frozen=True)
class Trajectories:
    """Steps of the environments of a header: N environments, T steps each.

    Column t of `actions` is the action in observation t, and column t of `rewards` and of the ends
    what it led to. An ended episode is followed by the first observation of the next one.
    """

    header: Header
    actions: np.ndarray  # In [-1, 15)                                     int8    [N, T]
    rewards: np.ndarray  # Of the step                                     float32 [N, T]
    terminated: np.ndarray  # The game (or action -1) ended the episode    bool    [N, T]
    truncated: np.ndarray  # The time limit ended the episode              bool    [N, T]
    prev_level_complete: np.ndarray  # The level was completed by the step bool    [N, T]
    level_seeds: np.ndarray  # Level in observation t                      int32   [N, T + 1]
    # CRC-32 of the observations 0, K, 2 K, ... of all environments, uint8 [N, 64, 64, 3]; K is the
    # header's digest_interval.
    frame_digests: np.ndarray  # uint32 [T // K + 1]

    @property
    def ended(self) -> np.ndarray:
        """Whether a step ended an episode; bool [N, T]."""
        ended: np.ndarray = self.terminated | self.truncated
        return ended

    @property
    def first(self) -> np.ndarray:
        """Whether an observation is the first of an episode; bool [N, T + 1]."""
        return np.concatenate([np.ones((len(self.actions), 1), np.bool_), self.ended], axis=1)

    def save(self, path: str | Path) -> None:
        """Writes the file atomically.

        Raises:
            OSError: It cannot be written.
        """
        header = {"format": _FORMAT, "version": _VERSION, **dataclasses.asdict(self.header)}
        arrays = {name: getattr(self, name) for name in _ARRAYS}
        arrays["header"] = np.frombuffer(json.dumps(header).encode(), np.uint8)
        write_atomically(Path(path), lambda file: np.savez_compressed(file, **arrays))

    def require_equal(self, other: Trajectories, name: str) -> None:
        """Raises DataLossError at the first difference; `other` is a replay, `name` the file's.

        Digests of frames are compared if both have them.
        """
        for array in ("level_seeds", "rewards", "terminated", "truncated", "prev_level_complete"):
            recorded, replayed = getattr(self, array), getattr(other, array)
            different = recorded.view(np.uint8) != replayed.view(np.uint8)  # NaNs are equal.
            if different.any():
                columns = different.reshape(*recorded.shape, -1).any(axis=2)
                step = int(np.argmax(columns.any(axis=0)))
                env = int(np.argmax(columns[:, step]))
                raise DataLossError(
                    f"{name}: {array} of environment {env} at step {step} was recorded as "
                    f"{recorded[env, step]} and is replayed as {replayed[env, step]}"
                    f"{_engines(self.header, other.header)}"
                )
        if len(self.frame_digests) and len(other.frame_digests):
            wrong = np.flatnonzero(self.frame_digests != other.frame_digests)
            if len(wrong):
                step = int(wrong[0]) * self.header.digest_interval
                art = "the project's own art" if other.header.art is None else other.header.art
                raise DataLossError(
                    f"{name}: frames at step {step} differ from the recorded ones; they were drawn "
                    f"with {art}{_engines(self.header, other.header)}"
                )


def load(path: str | Path) -> Trajectories:
    """Returns the trajectories in a file.

    Raises:
        OSError: The file cannot be read.
        DataLossError: It is no trajectory file, or is damaged, truncated, or of another version.
    """
    with open(path, "rb") as file:
        try:
            with np.load(file, allow_pickle=False) as archive:
                arrays = {name: archive[name] for name in archive.files}
            fields = json.loads(arrays.pop("header").tobytes())
            if fields.pop("format") != _FORMAT:
                raise ValueError("it has another format")
            version = fields.pop("version")
            header = Header(**fields) if version == _VERSION else None
        except Exception as error:  # What numpy and zipfile raise depends on the damage.
            raise DataLossError(
                f"{path} is not a trajectory file, or is damaged or truncated: {error}"
            ) from None
    if header is None:
        raise DataLossError(
            f"{path} has version {version} of the format; this program reads {_VERSION}"
        )
    for name, (dtype, extra) in _ARRAYS.items():
        expected: tuple[int, ...] = (header.digest_count,)
        if extra is not None:
            expected = (header.env_count, header.step_count + extra)
        given = arrays.get(name)
        if given is None or given.dtype != dtype or given.shape != expected:
            what = "is missing" if given is None else f"is {given.dtype} {list(given.shape)}"
            raise DataLossError(
                f"{path} is damaged: {name} {what}; it is {np.dtype(dtype)} {list(expected)}"
            )
    return Trajectories(header, *(arrays[name] for name in _ARRAYS))


def part_name(game: str, part: int, part_count: int) -> str:
    """Returns the name of a part of a game's recording, without a suffix."""
    return f"{game}-{part:05d}-of-{part_count:05d}"


def find(paths: Iterable[str | Path]) -> list[Path]:
    """Returns the trajectory files among files and folders, in order.

    Raises:
        NotFoundError: There is no such file, or a folder has none.
        InvalidArgumentError: A folder has some parts of a game's recording, but not all.
    """
    found: list[Path] = []
    for path in map(Path, paths):
        if not path.is_dir():
            if not path.exists():
                raise NotFoundError(f"{path} does not exist; give trajectory files or folders")
            found.append(path)
            continue
        files = sorted(path.glob(f"*{SUFFIX}"))
        if not files:
            raise NotFoundError(f"{path} has no *{SUFFIX}; procgen-dataset record writes them")
        _require_all_parts(path, files)
        found += files
    return found


def _require_all_parts(folder: Path, files: list[Path]) -> None:
    counts: dict[tuple[str, int], int] = {}
    for file in files:
        match = re.fullmatch(r"(.+)-\d{5}-of-(\d{5})", file.name[: -len(SUFFIX)])
        if match:
            key = (match[1], int(match[2]))
            counts[key] = counts.get(key, 0) + 1
    for (name, part_count), count in counts.items():
        if count != part_count:
            raise InvalidArgumentError(
                f"{folder} has {count} of {part_count} parts of {name}: repeat the command that "
                "records it, or give the files"
            )


def _engines(recorded: Header, replayed: Header) -> str:
    if recorded.engine == replayed.engine:
        return ""
    return f"; recorded by version {recorded.engine} of the engine, replayed by {replayed.engine}"
