"""Reads the answers of StepPool without copying pictures, and writes its requests.

Protocol Buffers would copy every observation twice on its way into an array: into the message, and
out of it. But on the wire each array of a batch is the little-endian array itself (proto/README.md,
"On the wire"), so a view of the received bytes will do. What is written in another way than a
server of today writes it (fields unpacked, or in several pieces: both allowed by Protocol Buffers)
goes the long way through the generated message, with the same result.

Requests are put together of serialised fields, which Protocol Buffers allows in any order: what is
the same from step to step is serialised once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from procgen_client._proto import step_pb2

_VARINT, _FIXED64, _BYTES, _FIXED32 = 0, 1, 2, 5

# Arrays of numbers: name, element type on the wire.
ARRAY_TYPES = {
    "rewards": np.dtype("<f4"),
    "first": np.dtype("?"),
    "terminated": np.dtype("?"),
    "truncated": np.dtype("?"),
    "level_seeds": np.dtype("<i4"),
    "prev_level_seeds": np.dtype("<i4"),
    "prev_level_complete": np.dtype("?"),
    "episode_returns": np.dtype("<f4"),
    "episode_lengths": np.dtype("<i4"),
    "fingerprints": np.dtype("<u8"),
}
PICTURES = ("final_observations", "observations")
_SCALARS = (
    "first_env",
    "env_count",
    "last",
)

_BATCH_FIELDS = step_pb2.Batch.DESCRIPTOR.fields_by_name
_SCALAR_NUMBERS = {_BATCH_FIELDS[name].number: name for name in _SCALARS}
_ARRAY_NUMBERS = {_BATCH_FIELDS[name].number: name for name in (*ARRAY_TYPES, *PICTURES)}
_RESPONSE_FIELDS = step_pb2.StepPoolResponse.DESCRIPTOR.fields_by_name
_SEQUENCE_NUMBER = _RESPONSE_FIELDS["sequence_number"].number
_BATCH = _RESPONSE_FIELDS["batch"].number


class _OtherwiseWrittenError(Exception):
    """The message may be right, but is not written the way that is read here."""


@dataclass(slots=True)
class Part:
    """One response with a batch: the answer to a request, or a part of it.

    ``arrays`` maps the names of Batch's arrays to one-dimensional arrays. Numbers are copies and
    writable; pictures are uint8 views of the received message and read-only.
    """

    sequence_number: int
    first_env: int
    env_count: int
    last: bool
    arrays: dict[str, np.ndarray]


def read_response(message: bytes | memoryview) -> Part | step_pb2.StepPoolResponse:
    """Reads a serialised StepPoolResponse: a Part if it bears a batch, else the message itself.

    Raises:
        google.protobuf.message.DecodeError: The bytes are no such message.
    """
    try:
        return _read_batch_response(message)
    except (_OtherwiseWrittenError, IndexError, ValueError):
        response = step_pb2.StepPoolResponse.FromString(bytes(message))
        return part_of(response) if response.WhichOneof("response") == "batch" else response


def part_of(response: step_pb2.StepPoolResponse) -> Part:
    """Gives what read_response gives, by way of the generated message: the slow and obvious way."""
    batch = response.batch
    # Fingerprints are 64 bits that the contract sends as signed numbers.
    arrays = {
        name: np.array(getattr(batch, name), dtype.str.replace("u", "i")).view(dtype)
        for name, dtype in ARRAY_TYPES.items()
    }
    arrays |= {name: np.frombuffer(getattr(batch, name), np.uint8) for name in PICTURES}
    return Part(
        response.sequence_number,
        batch.first_env,
        batch.env_count,
        batch.last,
        arrays,
    )


def _read_batch_response(message: bytes | memoryview) -> Part:
    sequence_number = 0
    batch_range: tuple[int, int] | None = None
    for number, kind, value in _fields(message, 0, len(message)):
        if number == _SEQUENCE_NUMBER and kind == _VARINT:
            sequence_number = value
        elif number == _BATCH and kind == _BYTES and batch_range is None:
            batch_range = value
        else:
            raise _OtherwiseWrittenError
    if batch_range is None:
        raise _OtherwiseWrittenError

    scalars: dict[str, Any] = {}
    ranges: dict[str, tuple[int, int]] = {}
    for number, kind, value in _fields(message, *batch_range):
        if kind == _VARINT and number in _SCALAR_NUMBERS:
            scalars[_SCALAR_NUMBERS[number]] = value
        elif kind == _BYTES and number in _ARRAY_NUMBERS and _ARRAY_NUMBERS[number] not in ranges:
            ranges[_ARRAY_NUMBERS[number]] = value
        elif number in _SCALAR_NUMBERS or number in _ARRAY_NUMBERS:
            raise _OtherwiseWrittenError
        # Anything else is a field of a later server, which clients ignore.

    return Part(
        sequence_number,
        scalars.get("first_env", 0),
        scalars.get("env_count", 0),
        bool(scalars.get("last")),
        _arrays(message, ranges),
    )


def _arrays(
    message: bytes | memoryview, ranges: dict[str, tuple[int, int]]
) -> dict[str, np.ndarray]:
    arrays: dict[str, np.ndarray] = {}
    for name, dtype in ARRAY_TYPES.items():
        begin, end = ranges.get(name, (0, 0))
        # Copies, so that the array is aligned and the caller's own; these are some bytes a row.
        if dtype.kind == "b":
            arrays[name] = np.frombuffer(message[begin:end], np.uint8) != 0
        else:
            arrays[name] = np.frombuffer(message[begin:end], dtype).copy()
    for name in PICTURES:
        begin, end = ranges.get(name, (0, 0))
        arrays[name] = np.frombuffer(message, np.uint8)[begin:end]
    return arrays


def _fields(message: bytes | memoryview, position: int, end: int) -> list[tuple[int, int, Any]]:
    """Lists the fields in message[position:end] as (number, wire type, value).

    The value is an int for a varint and the range (begin, end) for bytes.
    """
    fields: list[tuple[int, int, Any]] = []
    while position < end:
        tag, position = message[position], position + 1
        if tag >= 0x80:
            tag, position = _varint(message, position - 1)
        kind = tag & 7
        value: Any = None
        if kind == _VARINT:
            value, position = _varint(message, position)
        elif kind == _BYTES:
            size, position = _varint(message, position)
            value = (position, position + size)
            position += size
        elif kind == _FIXED32:
            position += 4
        elif kind == _FIXED64:
            position += 8
        else:
            raise _OtherwiseWrittenError
        fields.append((tag >> 3, kind, value))
    if position != end:
        raise _OtherwiseWrittenError
    return fields


def _varint(message: bytes | memoryview, position: int) -> tuple[int, int]:
    """Reads a varint; gives it and the position after it."""
    value = 0
    for shift in range(0, 70, 7):
        byte = message[position]
        position += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value, position
    raise _OtherwiseWrittenError


def varint(value: int) -> bytes:
    """Writes a number that is not negative."""
    if value < 0x80:
        return bytes((value,))
    if value < 0x4000:
        return bytes((value & 0x7F | 0x80, value >> 7))
    if value < 0x200000:
        return bytes((value & 0x7F | 0x80, value >> 7 & 0x7F | 0x80, value >> 14))
    written = bytearray()
    while value >= 0x80:
        written.append(value & 0x7F | 0x80)
        value >>= 7
    written.append(value)
    return bytes(written)


def number_tag(number: int) -> bytes:
    """Writes what comes before a number (varint) in a field."""
    return varint(number << 3 | _VARINT)


def bytes_field(number: int, value: bytes) -> bytes:
    """Writes a field with bytes: a message that is serialised, or packed numbers."""
    return varint(number << 3 | _BYTES) + varint(len(value)) + value
