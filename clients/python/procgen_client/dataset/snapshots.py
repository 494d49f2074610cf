"""Snapshots within trajectories, from which any step is reached soon.

They are made from the actions, and kept in a file beside the trajectory file, which can be deleted.
"""

from __future__ import annotations

import contextlib
import json
import os
import zlib
from pathlib import Path
from typing import NamedTuple

import numpy as np

from procgen_client import _library
from procgen_client._checkpoint import write_atomically
from procgen_client.dataset.play import open_pool
from procgen_client.dataset.trajectories import SUFFIX, Trajectories

_SUFFIX = ".snapshots.npz"
_VERSION = 1


class Snapshots(NamedTuple):
    """A snapshot of each environment at the steps 0, K, 2 K, ..."""

    interval: int  # K
    offsets: np.ndarray  # Of the snapshots in data, by step and environment  int64 [S * N + 1]
    data: np.ndarray  # Each compressed by zlib                               uint8

    def at(self, step: int, env: int, env_count: int) -> bytes:
        """Returns the latest snapshot of an environment that is not after a step."""
        index = step // self.interval * env_count + env
        begin, end = self.offsets[index : index + 2].tolist()
        return zlib.decompress(self.data[begin:end].data)


def snapshots_of(path: Path, trajectories: Trajectories, interval: int) -> Snapshots:
    """Returns snapshots within a file, from the file beside it if that is up to date.

    Otherwise they are made, at about half a million steps per second and core, and kept if the
    folder is writable.

    Raises:
        OSError: The trajectory file cannot be read.
        ProcgenError: As Pool.
    """
    identity = {
        "version": _VERSION,
        "engine": _library.library().version,
        "library_bytes": os.stat(_library.library().path).st_size,
        "trajectories": zlib.crc32(path.read_bytes()),
        "interval": interval,
    }
    name = path.name[: -len(SUFFIX)] if path.name.endswith(SUFFIX) else path.name
    cache = path.with_name(f"{name}{_SUFFIX}")
    # What numpy and zipfile raise depends on the damage.
    with contextlib.suppress(Exception), np.load(cache, allow_pickle=False) as archive:
        if json.loads(archive["header"].tobytes()) == identity:
            return Snapshots(interval, archive["offsets"], archive["data"])
    made = _made(trajectories, interval)
    arrays = {
        "header": np.frombuffer(json.dumps(identity).encode(), np.uint8),
        "offsets": made.offsets,
        "data": made.data,
    }
    with contextlib.suppress(OSError):
        write_atomically(cache, lambda file: np.savez(file, **arrays))
    return made


def _made(trajectories: Trajectories, interval: int) -> Snapshots:
    actions = np.ascontiguousarray(trajectories.actions.T)
    compressed: list[bytes] = []
    with open_pool(trajectories.header, art=None) as pool:
        for t, taken in enumerate(actions):
            if t % interval == 0:
                compressed += [zlib.compress(state, 1) for state in pool.save_states()]
            pool.step(taken, observe=False)
    offsets = np.zeros(len(compressed) + 1, np.int64)
    offsets[1:] = np.cumsum([len(each) for each in compressed])
    return Snapshots(interval, offsets, np.frombuffer(b"".join(compressed), np.uint8))
