"""Batches in memory that the server shares, read where they are (proto: SharedMemory)."""

from __future__ import annotations

import mmap
import os
import weakref
from collections import deque
from typing import NamedTuple

import numpy as np

from procgen_client._proto import step_pb2
from procgen_client._wire import ARRAY_TYPES, PICTURES, Part
from procgen_client.errors import FailedPreconditionError, InternalError

_ELEMENT_TYPES = {
    "|u1": step_pb2.ELEMENT_TYPE_UINT8,
    "|b1": step_pb2.ELEMENT_TYPE_BOOL,
    "<i4": step_pb2.ELEMENT_TYPE_INT32,
    "<u8": step_pb2.ELEMENT_TYPE_INT64,  # Fingerprints, which the contract calls signed.
    "<f4": step_pb2.ELEMENT_TYPE_FLOAT32,
}


class _Array(NamedTuple):
    offset_bytes: int
    row_bytes: int
    dtype: np.dtype


class SharedMapping:
    """The memory that a pool shares, and which batches of it are held.

    A batch is held as long as an array refers to it. That it is not any more is noticed on any
    thread, at any time; it is told to the server by who sends.

    Threads: one at a time, but for the arrays.

    Attributes:
        path: The file.
        batch_count: How many batches there are.
    """

    def __init__(self, memory: step_pb2.SharedMemory) -> None:
        """Maps it.

        Raises:
            FailedPreconditionError: The file cannot be mapped here.
            InternalError: The server says of it what cannot be.
        """
        self.path = memory.path
        self._held: dict[int, weakref.ref[np.ndarray]] = {}
        self._released: list[int] = []
        self._let_go: deque[int] = deque()  # By the garbage collector; not yet in the two above.
        self.map_again(memory)

    def map_again(self, memory: step_pb2.SharedMemory) -> None:
        """Maps it, perhaps with more batches than before; errors as of making it."""
        self._arrays, self._env_count = _read_arrays(memory)
        numbers = [self._arrays[name] for name in ARRAY_TYPES]
        self._numbers_begin = min(array.offset_bytes for array in numbers)
        self._numbers_end = max(
            array.offset_bytes + self._env_count * array.row_bytes for array in numbers
        )
        self._numbers_type = np.dtype(
            {
                "names": list(ARRAY_TYPES),
                "formats": [(array.dtype, (self._env_count,)) for array in numbers],
                "offsets": [array.offset_bytes - self._numbers_begin for array in numbers],
                "itemsize": self._numbers_end - self._numbers_begin,
            }
        )
        self.batch_count = memory.batch_count
        self._batch_bytes = memory.batch_bytes
        try:
            self._memory = _map(memory.path, memory.size_bytes)
        except (OSError, ValueError) as error:
            raise FailedPreconditionError(
                f"cannot map the pool's shared memory {memory.path}: {error}; it can be mapped on "
                "the server's machine (and in its container), by its user; elsewhere make the pool "
                'with transport="stream"'
            ) from error

    @property
    def held_count(self) -> int:
        """How many batches are held."""
        self._note_let_go()
        return len(self._held)

    def take_released(self) -> list[int]:
        """Gives the batches that were let go of since the server was told the last time."""
        self._note_let_go()
        released, self._released = self._released, []
        return released

    def take_held(self) -> list[int]:
        """Gives those that are held, to be told as a whole: no others are to be released then."""
        self._note_let_go()
        self._released = []
        return sorted(self._held)

    def read(self, part: Part) -> None:
        """Gives `part` its arrays: pictures are views, which hold the batch; numbers are copies.

        Raises:
            InternalError: It tells of what is not there.
        """
        number, first, count = part.shared_batch, part.first_environment, part.environment_count
        if (
            number is None
            or not 0 <= number < self.batch_count
            or first < 0
            or count < 1
            or first + count > self._env_count
        ):
            raise InternalError(
                f"the server answers with {count} environments from {first} on in batch {number} "
                "of shared memory, which there are not"
            )
        memory = np.frombuffer(
            self._memory, np.uint8, self._batch_bytes, number * self._batch_bytes
        )
        # All views of it, and views of those, refer to this array, and nothing else does.
        let_go, batch = self._let_go, number
        self._held[number] = weakref.ref(memory, lambda _: let_go.append(batch))

        # One copy for all numbers, which lie side by side.
        copy = memory[self._numbers_begin : self._numbers_end].copy()
        numbers: np.ndarray = np.ndarray((), self._numbers_type, copy)
        rows = slice(first, first + count)
        arrays = {name: numbers[name][rows] for name in ARRAY_TYPES}
        ended = int(np.count_nonzero(arrays["terminated"] | arrays["truncated"]))
        arrays["fingerprints"] = arrays["fingerprints"][:ended]

        for name, row_count, is_shared in (
            ("final_observations", ended, part.shared_final_observations),
            ("observations", count, part.shared_observations),
        ):
            array = self._arrays[name]
            begin = array.offset_bytes + first * array.row_bytes
            end = begin + (row_count * array.row_bytes if is_shared else 0)
            arrays[name] = memory[begin:end]
        part.arrays = arrays

    def _note_let_go(self) -> None:
        while self._let_go:
            number = self._let_go.popleft()
            del self._held[number]
            self._released.append(number)


def _map(path: str, size_bytes: int) -> mmap.mmap:
    file = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        return mmap.mmap(file, size_bytes, flags=mmap.MAP_SHARED, prot=mmap.PROT_READ)
    finally:
        os.close(file)


def _read_arrays(memory: step_pb2.SharedMemory) -> tuple[dict[str, _Array], int]:
    """Gives where each array is, and how many rows all have."""
    told = {array.field: array for array in memory.arrays}
    types = ARRAY_TYPES | dict.fromkeys(PICTURES, np.dtype(np.uint8))
    if memory.batch_count < 1 or memory.batch_count * memory.batch_bytes != memory.size_bytes:
        raise InternalError(f"the server's shared memory {memory.path} is not told as a whole")
    arrays: dict[str, _Array] = {}
    env_count = 0
    for name, dtype in types.items():
        array = told.get(name)
        if array is None or array.element_type != _ELEMENT_TYPES[dtype.str] or not array.shape:
            raise InternalError(
                f"the server's shared memory {memory.path} has no array {name} of its type"
            )
        env_count = env_count or array.shape[0]
        row_bytes = dtype.itemsize * int(np.prod(array.shape[1:], dtype=np.int64))
        end = array.offset_bytes + env_count * row_bytes
        if (
            min(array.shape) < 1
            or array.shape[0] != env_count
            or array.offset_bytes < 0
            or array.offset_bytes % 64
            or end > memory.batch_bytes
        ):
            raise InternalError(
                f"the server's shared memory {memory.path} has an array {name} that does not fit"
            )
        arrays[name] = _Array(array.offset_bytes, row_bytes, dtype)
    return arrays, env_count
