"""The trace of a learner's responses, for comparison with another learner's."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from procgen_client import Batch

FIELDS = (
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


def digests_of(batch: Batch) -> list[int]:
    """Returns a checksum of each field, including its shape."""
    return [_digest(getattr(batch, field)) for field in FIELDS]


def difference(expected: Trace, actual: Trace) -> str | None:
    """Returns the first difference of two traces; None if they are equal."""
    if len(expected.digests) != len(actual.digests):
        return f"{len(actual.digests)} answers in place of {len(expected.digests)}"
    rows = np.flatnonzero((expected.digests != actual.digests).any(axis=1))
    if not len(rows):
        return None
    row = int(rows[0])
    unequal = expected.digests[row] != actual.digests[row]
    fields = [field for field, differs in zip(FIELDS, unequal, strict=True) if differs]
    return f"the answer to request {row} differs in {', '.join(fields)}; so do {len(rows) - 1} more"


def _digest(array: np.ndarray | None) -> int:
    if array is None:
        return 0
    shape = zlib.crc32(repr(array.shape).encode())
    return zlib.crc32(np.ascontiguousarray(array).view(np.uint8), shape)
