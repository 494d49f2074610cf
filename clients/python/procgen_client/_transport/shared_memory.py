"""Batches in memory that the server shares, read where they are (proto: SharedMemory)."""

from __future__ import annotations

import functools
import math
import mmap
import os
import stat
import weakref
from collections import deque
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np
from google.protobuf.message import DecodeError

from procgen_client._proto import pools_pb2, step_pb2
from procgen_client._requests import Request
from procgen_client._transport.wire import ARRAY_TYPES, PICTURES, bytes_field, varint
from procgen_client.batch import Batch
from procgen_client.errors import FailedPreconditionError, InternalError

_ELEMENT_TYPES = {
    "|u1": step_pb2.ELEMENT_TYPE_UINT8,
    "|b1": step_pb2.ELEMENT_TYPE_BOOL,
    "<i4": step_pb2.ELEMENT_TYPE_INT32,
    "<u8": step_pb2.ELEMENT_TYPE_INT64,  # Fingerprints, which the contract calls signed.
    "<f4": step_pb2.ELEMENT_TYPE_FLOAT32,
}
_RELEASED_BATCHES = step_pb2.StepPoolRequest.DESCRIPTOR.fields_by_name["released_batches"].number
# Of so many different answers it is known where their values are. More are seldom given.
_ROWS_KNOWN_MAX = 1024


class _Array(NamedTuple):
    offset_bytes: int  # From the batch's beginning.
    row_shape: tuple[int, ...]
    dtype: np.dtype

    def begin(self, row: int) -> int:
        """Where a row begins, in bytes from the batch's beginning."""
        return self.offset_bytes + row * self.dtype.itemsize * math.prod(self.row_shape)


class _Rows(NamedTuple):
    """What an answer tells of: some rows of a batch."""

    batch: int  # Its number in the mapping.
    first_env: int
    env_count: int
    memory: memoryview  # Of the whole batch.
    pictures_type: np.dtype  # The arrays of these rows in there, as the fields of one element.
    has_observations: bool  # They are written.
    has_final_observations: bool
    numbers: memoryview  # All numbers of the batch, which lie side by side.
    numbers_type: np.dtype  # As pictures_type.
    let_go: Callable[[object], None]  # Notes that the batch is held no more.


class _SharedBatch(Batch):
    """A batch whose arrays of numbers are made when they are first asked for; few are."""

    __slots__ = ("numbers",)

    numbers: np.ndarray  # All of them, as the fields of one element.

    def __getattr__(self, name: str) -> np.ndarray:
        """Makes an array, once: no other attribute is missing."""
        if name not in ARRAY_TYPES:
            raise AttributeError(f"a batch has no {name}")
        array = self.numbers[name]
        if name == "fingerprints":
            array = array[: self.ended_count()]
        setattr(self, name, array)
        return array

    def ended_count(self) -> int:
        """How many episodes ended."""
        return int(np.count_nonzero(self.terminated | self.truncated))


class SharedMapping:
    """The memory that a pool shares, and which batches of it are held.

    A batch is held as long as an array refers to it. That it is not any more is noticed on any
    thread, at any time; it is told to the server by who sends.

    Threads: one at a time, but for the arrays.

    Attributes:
        path: The file.
        batch_count: How many batches there are.
    """

    def __init__(self, memory: step_pb2.SharedMemory, pool: pools_pb2.Pool) -> None:
        """Maps it.

        Raises:
            FailedPreconditionError: The file cannot be mapped here.
            InternalError: The server says of it what cannot be.
        """
        self.path = memory.path
        self._pool = pool
        self._held: dict[int, weakref.ref[np.ndarray]] = {}
        self._released = b""  # Written, for the server.
        self._let_go: deque[int] = deque()  # By the garbage collector; not yet in the two above.
        self.map_again(memory)

    def map_again(self, memory: step_pb2.SharedMemory) -> None:
        """Maps it, perhaps with more batches than before; errors as of making it."""
        self._arrays = _read_arrays(memory, self._pool)
        self._env_count = self._pool.spec.env_count
        self._picture_shape = self._arrays["observations"].row_shape
        self._no_pictures = np.zeros((0, *self._picture_shape), np.uint8)
        self._no_pictures.flags.writeable = False
        self._known: dict[bytes, _Rows] = {}  # By answers without their sequence numbers.
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

    def take_released(self) -> bytes:
        """Gives what tells the server of the batches let go of since it was told the last time.

        Fields of a serialised StepPoolRequest.
        """
        self._note_let_go()
        released, self._released = self._released, b""
        return released

    def take_held(self) -> list[int]:
        """Gives those that are held, to be told as a whole: no others are to be released then."""
        self._note_let_go()
        self._released = b""
        return sorted(self._held)

    def read(self, message: bytes, request: Request) -> Batch | None:
        """Gives the batch that a response answers a request with; None: it answers otherwise.

        Its pictures are views, which hold it; its numbers are copies.

        Raises:
            InternalError: It tells of what is not there.
        """
        rows = self._rows_of(message, request)
        if rows is None:
            return None
        self._note_let_go()
        answered = (
            rows.first_env,
            rows.env_count,
            rows.has_observations,
            rows.has_final_observations,
        )
        if answered != request.expected or rows.batch in self._held:
            raise InternalError(
                f"the server answers request {request.sequence_number} in batch {rows.batch} of "
                f"shared memory with {answered}, expected: one that is not held, with "
                f"{request.expected and tuple(request.expected)}"
            )
        # All views of it, and views of those, refer to this array, and nothing else does.
        pictures: np.ndarray = np.ndarray((), rows.pictures_type, rows.memory)
        self._held[rows.batch] = weakref.ref(pictures, rows.let_go)
        batch = _SharedBatch.__new__(_SharedBatch)
        batch.sequence_number = request.sequence_number
        batch.first_env = rows.first_env
        batch.numbers = np.ndarray((), rows.numbers_type, bytearray(rows.numbers))
        batch.observations = pictures["observations"] if rows.has_observations else None
        ended_count = batch.ended_count() if rows.has_final_observations else 0
        batch.final_observations = (
            pictures["final_observations"][:ended_count] if ended_count else self._no_pictures
        )
        return batch

    def _rows_of(self, message: bytes, request: Request) -> _Rows | None:
        """Gives what a response tells of; None: of no batch, or it answers another request."""
        told = message[len(request.head) :] if message.startswith(request.head) else b""
        rows = self._known.get(told)
        if rows is not None:
            return rows
        try:
            response = step_pb2.StepPoolResponse.FromString(message)
        except DecodeError:
            return None  # Who reads it otherwise tells.
        if not response.batch.HasField("shared_batch") or (
            response.sequence_number != request.sequence_number
        ):
            return None
        rows = self._find(response.batch)
        if told:
            if len(self._known) == _ROWS_KNOWN_MAX:
                self._known.clear()
            self._known[told] = rows
        return rows

    def _find(self, batch: step_pb2.Batch) -> _Rows:
        number, first, count = batch.shared_batch, batch.first_env, batch.env_count
        if (
            not 0 <= number < self.batch_count
            or first < 0
            or count < 1
            or first + count > self._env_count
        ):
            raise InternalError(
                f"the server answers with {count} environments from {first} on in batch {number} "
                "of shared memory, which there are not"
            )
        batch_begin = number * self._batch_bytes
        memory = memoryview(self._memory)[batch_begin : batch_begin + self._batch_bytes]
        numbers_begin = min(self._arrays[name].begin(0) for name in ARRAY_TYPES)
        numbers_end = max(self._arrays[name].begin(self._env_count) for name in ARRAY_TYPES)
        let_go = self._let_go
        return _Rows(
            batch=number,
            first_env=first,
            env_count=count,
            memory=memory,
            pictures_type=self._type_of_rows(PICTURES, 0, first, count),
            has_observations=batch.shared_observations,
            has_final_observations=batch.shared_final_observations,
            numbers=memory[numbers_begin:numbers_end],
            numbers_type=self._type_of_rows(ARRAY_TYPES, numbers_begin, first, count),
            let_go=lambda _: let_go.append(number),
        )

    def _type_of_rows(self, names: Iterable[str], begin: int, first: int, count: int) -> np.dtype:
        """Gives rows of these arrays as the fields of one element, which begins at a byte."""
        arrays = [self._arrays[name] for name in names]
        return np.dtype(
            {
                "names": list(names),
                "formats": [(array.dtype, (count, *array.row_shape)) for array in arrays],
                "offsets": [array.begin(first) - begin for array in arrays],
            }
        )

    def _note_let_go(self) -> None:
        while self._let_go:
            number = self._let_go.popleft()
            del self._held[number]
            self._released += _release(number)


@functools.lru_cache(maxsize=None)  # There are few batches.
def _release(batch: int) -> bytes:
    """Writes that a batch is released: a field of StepPoolRequest, which may come again."""
    return bytes_field(_RELEASED_BATCHES, varint(batch))


def _map(path: str, size_bytes: int) -> mmap.mmap:
    # Opening a pipe must not wait for somebody to write to it.
    file = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    try:
        if not stat.S_ISREG(os.fstat(file).st_mode):
            raise ValueError("it is no file")
        return mmap.mmap(file, size_bytes, flags=mmap.MAP_SHARED, prot=mmap.PROT_READ)
    finally:
        os.close(file)


def _read_arrays(memory: step_pb2.SharedMemory, pool: pools_pb2.Pool) -> dict[str, _Array]:
    """Gives where each array is, which has a row for each environment of the pool."""
    told = {array.field: array for array in memory.arrays}
    types = ARRAY_TYPES | dict.fromkeys(PICTURES, np.dtype(np.uint8))
    env_count = pool.spec.env_count
    if memory.batch_count < 1 or memory.batch_count * memory.batch_bytes != memory.size_bytes:
        raise InternalError(f"the server's shared memory {memory.path} is not told as a whole")
    arrays: dict[str, _Array] = {}
    for name, dtype in types.items():
        array = told.get(name)
        row_shape = tuple(pool.observation_shape) if name in PICTURES else ()
        if (
            array is None
            or array.element_type != _ELEMENT_TYPES[dtype.str]
            or tuple(array.shape) != (env_count, *row_shape)
        ):
            raise InternalError(
                f"the server's shared memory {memory.path} has no array {name} of its type and of "
                f"shape {[env_count, *row_shape]}"
            )
        read = _Array(array.offset_bytes, row_shape, dtype)
        if (
            array.offset_bytes < 0
            or array.offset_bytes % 64
            or read.begin(env_count) > memory.batch_bytes
        ):
            raise InternalError(
                f"the server's shared memory {memory.path} has an array {name} that does not fit"
            )
        arrays[name] = read
    return arrays
