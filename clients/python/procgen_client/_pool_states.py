"""The levels and states of a pool: sampled, saved, restored, read and drawn."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from procgen_client import _structs
from procgen_client._pool_requests import Requests
from procgen_client._requests import in_range
from procgen_client.errors import InvalidArgumentError
from procgen_client.objects import COLUMNS, OBJECTS_MAX, Objects
from procgen_client.options import LevelSampler


class States(Requests):
    """The part of a Pool for levels and states."""

    games: tuple[str, ...]
    options: dict[str, Any]

    def set_level_sampler(self, level_sampler: LevelSampler) -> None:
        """Replaces the level sampler; takes effect at each environment's next episode.

        Errors as :meth:`step`.
        """
        struct, _kept = _structs.level_sampler(level_sampler)
        self._call(self._library.set_level_sampler, ctypes.byref(struct))
        self.options["level_sampler"] = level_sampler

    def save_states(self, environments: Sequence[int] | None = None) -> list[bytes]:
        """Returns snapshots of environments; the environments do not change.

        A snapshot is complete: an environment restored from it continues as this one does, bit for
        bit, in any pool of the same game, in any process. Two things belong to the pool: a frame
        stack, which starts with copies of one frame, and the list of a level sampler.

        Args:
            environments: Indices in the pool, in any order, each at most once. None: all.

        Returns:
            A snapshot of each, of 1 to 26 kB, in the order of `environments`.

        Raises:
            InvalidArgumentError: An environment is out of range or given twice.
            FailedPreconditionError: Requests are unanswered.
        """
        return self._saved(range(self.env_count) if environments is None else environments)

    def restore_states(self, states: Mapping[int, bytes] | Sequence[bytes]) -> None:
        """Restores environments from snapshots; :meth:`observe` returns what it returned then.

        Options (mode, levels, appearance) and the choice of levels come from the snapshots; the
        autoreset mode remains the pool's. All or nothing, on a server for states that fit one
        request (4 MiB by default).

        Args:
            states: Snapshots by environment (index in the pool), or a list with one for each
                environment.

        Raises:
            InvalidArgumentError: An environment is out of range, a list has a wrong length, or a
                snapshot contains an impossible value.
            FailedPreconditionError: A snapshot is of another game than the environment's; or
                requests are unanswered.
            DataLossError: A snapshot is damaged or of another version.
        """
        if not isinstance(states, Mapping):
            if len(states) != self.env_count:
                raise InvalidArgumentError(
                    f"states has {len(states)} entries; there are {self.env_count} environments (a "
                    "dict restores some of them)"
                )
            states = dict(enumerate(states))
        for state in states.values():
            if not isinstance(state, bytes):
                raise InvalidArgumentError(f"a state is {type(state).__name__}; it is bytes")
        indices = _structs.indices(states)
        offsets = np.zeros(len(indices) + 1, np.uintp)
        offsets[1:] = np.cumsum([len(state) for state in states.values()])
        data = b"".join(states.values())
        self._call(
            *(self._library.restore_states, indices.ctypes.data, len(indices)),
            *(data, offsets.ctypes.data),
        )

    def clone_states(self, pairs: Iterable[tuple[int, int]]) -> None:
        """Copies states of environments to other environments of this pool. All or nothing.

        All sources are read before any target is written, so states can be exchanged. Between
        pools: save_states and restore_states.

        Args:
            pairs: (source, target): indices in the pool. Each target at most once.

        Raises:
            InvalidArgumentError: An environment is out of range, or a target is given twice.
            FailedPreconditionError: The environments play different games; or requests are
                unanswered.
        """
        pairs = list(pairs)
        if not pairs:
            return
        sources = _structs.indices(source for source, _ in pairs)
        targets = _structs.indices(target for _, target in pairs)
        self._call(
            self._library.clone_states, sources.ctypes.data, targets.ctypes.data, len(pairs)
        )

    def render(
        self,
        environments: Sequence[int] | None = None,
        *,
        size_px: int = 512,
        whole_level: bool = False,
    ) -> list[np.ndarray]:
        """Draws environments for people; the environments do not change.

        Args:
            environments: Indices in the pool, in any order. None: all.
            size_px: Side of the square frames in pixels, in [16, 2048].
            whole_level: Whether to show the whole level instead of the agent's surroundings.

        Returns:
            uint8 arrays [size_px, size_px, 3] (RGB, top row first), in the order of `environments`.

        Raises:
            InvalidArgumentError: An environment or the size is out of range.
            FailedPreconditionError: Requests are unanswered.
            UnimplementedError: The server has no rendering.
        """
        side = in_range("size_px", size_px, 16, 2048)
        frames = []
        for environment in range(self.env_count) if environments is None else environments:
            frame = np.empty((side, side, 3), np.uint8)
            index = in_range("environment", environment, 0, self.env_count - 1)
            self._call(self._library.render, index, side, whole_level, frame.ctypes.data)
            frames.append(frame)
        return frames

    def objects(
        self, objects_max: int = 64, *, first_env: int = 0, env_count: int | None = None
    ) -> Objects:
        """Returns the objects of a slice (default: the whole pool) as arrays.

        In this process it copies nothing but the numbers, so a probe can read them at every step. A
        server sends snapshots for it.

        Args:
            objects_max: Number of rows of each environment, K, in [1, 4096]. Objects beyond it are
                left out.
            first_env, env_count: As step.

        Raises:
            InvalidArgumentError: An argument is out of range.
            FailedPreconditionError: Requests are unanswered.
        """
        rows = in_range("objects_max", objects_max, 1, OBJECTS_MAX)
        count = self._count_of(first_env, env_count)
        values = np.empty((count, rows, len(COLUMNS)), np.float32)
        counts = np.empty(count, np.int32)
        self._call(
            *(self._library.read_objects, first_env, count, rows),
            *(values.ctypes.data, counts.ctypes.data),
        )
        first = int(self.options.get("first_env") or 0) + first_env
        games = tuple(self.games[(first + i) % len(self.games)] for i in range(count))
        return Objects(values, counts, games)
