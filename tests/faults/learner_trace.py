"""The trace of a learner's responses, for comparison with another learner's."""

from __future__ import annotations

import zlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from procgen_client import Batch

_BATCH_FIELDS = (
    "observations",
    "rewards",
    "first",
    "terminated",
    "truncated",
    "level_seeds",
    "prev_level_seeds",
    "prev_level_complete",
    "episode_returns",
    "episode_lengths",
    "fingerprints",
    "final_observations",
)
# What a response can contain.
FIELDS = (*_BATCH_FIELDS, "states", "frames", "rejection")
Digest = list[int]  # A checksum of each of FIELDS; 0: absent.


@dataclass(frozen=True)
class Trace:
    """Row i is the response to request i."""

    digests: np.ndarray  # A checksum of each of FIELDS               uint32  [n, fields]
    durations: np.ndarray  # Since its sending or the last response    float64 [n], in seconds

    def save(self, path: Path) -> None:
        """Writes the trace to a file."""
        with open(path, "wb") as file:
            np.savez(file, digests=self.digests, durations=self.durations)

    @staticmethod
    def load(path: Path) -> Trace:
        """Reads a trace that save() wrote."""
        with np.load(path) as file:
            return Trace(file["digests"], file["durations"])


def digest_of(
    batch: Batch | None = None,
    *,
    states: Iterable[bytes] = (),
    frames: Iterable[np.ndarray] = (),
    rejection: str = "",
) -> Digest:
    """Returns a checksum of each field; those of arrays include their shapes."""
    rows = [None if batch is None else _valid_rows(batch, field) for field in _BATCH_FIELDS]
    return [
        *map(_checksum, rows),
        zlib.crc32(b"".join(states)),
        sum(map(_checksum, frames)) % 2**32,
        zlib.crc32(rejection.encode()),
    ]


def difference(expected: Trace, actual: Trace) -> str | None:
    """Returns the first difference of two traces; None if they are equal."""
    if len(expected.digests) != len(actual.digests):
        return f"{len(actual.digests)} responses instead of {len(expected.digests)}"
    rows = np.flatnonzero((expected.digests != actual.digests).any(axis=1))
    if not len(rows):
        return None
    row = int(rows[0])
    unequal = expected.digests[row] != actual.digests[row]
    fields = [field for field, differs in zip(FIELDS, unequal, strict=True) if differs]
    more = len(rows) - 1
    return f"the response to request {row} differs in {', '.join(fields)}; so do {more} more"


def _valid_rows(batch: Batch, field: str) -> np.ndarray | None:
    values: np.ndarray | None = getattr(batch, field)
    if field in ("fingerprints", "final_observations") and values is not None:
        return values[batch.ended]
    return values


def _checksum(array: np.ndarray | None) -> int:
    if array is None:
        return 0
    shape = zlib.crc32(repr(array.shape).encode())
    return zlib.crc32(np.ascontiguousarray(array).view(np.uint8), shape)
