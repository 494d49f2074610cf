"""Tensors of dm_env_rpc: validated reading, and packing."""

from __future__ import annotations

from typing import Any

import numpy as np
from dm_env_rpc.v1 import dm_env_rpc_pb2 as pb2

from procgen_client.errors import InvalidArgumentError

# Element types, by the field of a Tensor that has the elements.
_TYPES: dict[str, type] = {
    "floats": np.float32,
    "doubles": np.float64,
    "int8s": np.int8,
    "int32s": np.int32,
    "int64s": np.int64,
    "uint8s": np.uint8,
    "uint32s": np.uint32,
    "uint64s": np.uint64,
    "bools": np.bool_,
    "strings": np.str_,
}
_FIELDS: dict[np.dtype, str] = {np.dtype(of): field for field, of in _TYPES.items()}
# What errors call the fields that a tensor may have, and these fields.
VALUE = ("numbers, booleans or text", frozenset(_TYPES))
INTEGER = ("an integer type", frozenset(field for field in _TYPES if "int" in field))
INT32 = ("INT32", frozenset({"int32s"}))
UINT8 = ("UINT8", frozenset({"uint8s"}))
# Length of a list that may have any.
ANY = -1
# Dimensions that an error shows.
_SHOWN_MAX = 8


def data_type(dtype: np.dtype | type) -> int:
    """Returns the DataType of a type of numpy: the number of a Tensor's field."""
    number: int = pb2.Tensor.DESCRIPTOR.fields_by_name[_FIELDS[np.dtype(dtype)]].number
    return number


def pack(values: Any, tensor: Any) -> None:  # noqa: ANN401 - an array; a message
    """Writes an array, or a scalar of numpy, into a Tensor."""
    array = np.asarray(values)
    elements = getattr(tensor, _FIELDS[array.dtype])
    if array.dtype in (np.int8, np.uint8):
        elements.array = array.tobytes()
    else:
        elements.array.extend(array.ravel().tolist())
    tensor.shape.extend(array.shape)


def unpack(
    name: str, tensor: Any, kind: tuple[str, frozenset[str]], length: int | None  # noqa: ANN401
) -> Any:  # noqa: ANN401
    """Returns a number, a text, or a list of them.

    Args:
        name: What errors call it.
        tensor: The message.
        kind: VALUE, INTEGER, INT32 or UINT8.
        length: None: it is a scalar. ANY: a list. Else a list of this length, to which a single
            element is broadcast.

    Raises:
        InvalidArgumentError: It has another type or shape.
    """
    allowed, fields = kind
    field = tensor.WhichOneof("payload")
    if field not in fields:
        number = tensor.DESCRIPTOR.fields_by_name[field].number if field else 0
        given = pb2.DataType.Name(number) if number else "none"
        raise InvalidArgumentError(f"{name} has type {given}, allowed: {allowed}")
    array = getattr(tensor, field).array
    if isinstance(array, bytes):
        array = np.frombuffer(array, _TYPES[field]).tolist()
    values, shape = list(array), list(tensor.shape)
    count = len(values)
    if length is None:
        fits, wanted = not shape and count == 1, "[]"
    else:
        claimed = [count] if shape == [-1] else shape  # A negative dimension is inferred.
        wanted = "[N] with N elements" if length == ANY else f"[{length}]"
        fits = claimed == [count if length == ANY else length] and count in (1, claimed[0])
    if not fits:
        given = ", ".join(map(str, shape[:_SHOWN_MAX])) + ", ..." * (len(shape) > _SHOWN_MAX)
        raise InvalidArgumentError(
            f"{name} has shape [{given}] and {count} elements, allowed: shape {wanted}"
        )
    if length is None:
        return values[0]
    return values * length if count == 1 and length != ANY else values
