"""Responses of a real server with one field, at any depth, changed in one of them, by seed."""

from __future__ import annotations

import random

import hostile_answers
from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.message import Message

from procgen_client._proto import catalog_pb2, step_pb2

_PREFIX = "mutated_"
_METHODS = {method: kind for method, kind, _ in hostile_answers.UNARY.values()} | {
    "GetCatalog": catalog_pb2.Catalog
}
# Responses on the learner's stream: attach, observe, ten steps.
_STREAM_ANSWERS = 12
_TEXTS = ["", "pools/another", "\0", "a" * 70000, "é"]


def modes(count: int) -> list[str]:
    """Returns the modes of `count` seeds."""
    return [f"{_PREFIX}{seed}" for seed in range(count)]


def stream_answer(mode: str, message: bytes) -> bytes:
    """Returns the replacement of a StepPoolResponse."""
    response = step_pb2.StepPoolResponse.FromString(message)
    return _mutated(mode, response.sequence_number, response, message)


def unary_answer(mode: str, method: str, message: bytes) -> bytes:
    """Returns the replacement of a unary response."""
    if method not in _METHODS:
        return message
    return _mutated(mode, method, _METHODS[method].FromString(message), message)


def _mutated(mode: str, place: int | str, answer: Message, message: bytes) -> bytes:
    """Returns `answer` changed if this mode changes it, else `message`."""
    if not mode.startswith(_PREFIX):
        return message
    chance = random.Random(mode)
    if place != chance.choice([*range(_STREAM_ANSWERS), *_METHODS]):
        return message
    _mutate(answer, chance)
    return answer.SerializeToString()


def _mutate(message: Message, chance: random.Random) -> None:
    present = [field for field, _ in message.ListFields()]
    fields = present if present and chance.random() < 0.8 else message.DESCRIPTOR.fields
    if not fields:
        return
    field = chance.choice(fields)
    if field.label == FieldDescriptor.LABEL_REPEATED:
        _mutate_repeated(message, field, chance)
    elif field.message_type is None:
        setattr(message, field.name, _value(field, getattr(message, field.name), chance))
    elif message.HasField(field.name) and chance.random() < 0.1:
        message.ClearField(field.name)
    else:
        getattr(message, field.name).SetInParent()
        _mutate(getattr(message, field.name), chance)


def _mutate_repeated(message: Message, field: FieldDescriptor, chance: random.Random) -> None:
    values = getattr(message, field.name)
    change = chance.choice(["clear", "cut", "repeat", "replace"])
    if change == "clear" or not values:
        message.ClearField(field.name)
    elif change == "cut":
        del values[chance.randrange(len(values)) :]
    elif change == "repeat":
        values.extend(list(values)[: chance.randint(1, len(values))])
    elif field.message_type is not None:
        _mutate(chance.choice(values), chance)
    else:
        index = chance.randrange(len(values))
        values[index] = _value(field, values[index], chance)


def _value(field: FieldDescriptor, before: object, chance: random.Random) -> object:
    """Returns another value for a scalar field."""
    if field.enum_type is not None:
        return chance.choice([0, 1, 2, 3, 99, -1])
    kind = field.cpp_type
    if kind == FieldDescriptor.CPPTYPE_BOOL:
        return not before
    if kind in (FieldDescriptor.CPPTYPE_FLOAT, FieldDescriptor.CPPTYPE_DOUBLE):
        return chance.choice([0.0, -1.0, float("nan"), float("inf")])
    if field.type == FieldDescriptor.TYPE_BYTES:
        return _bytes(before, chance)
    if kind == FieldDescriptor.CPPTYPE_STRING:
        return chance.choice(_TEXTS)
    bits = 63 if kind == FieldDescriptor.CPPTYPE_INT64 else 31
    least, most = -(2**bits), 2**bits - 1
    value = chance.choice([0, 1, -1, least, most, before + 1, before - 1])
    return min(max(value, least), most)


def _bytes(before: bytes, chance: random.Random) -> bytes:
    changed = bytearray(before)
    at = chance.randint(0, len(changed))
    change = chance.choice(["cut", "extend", "flip"])
    if change == "cut":
        del changed[at:]
    elif change == "extend":
        changed[at:at] = chance.randbytes(chance.randint(1, 100))
    else:
        for _ in range(3 if changed else 0):
            changed[chance.randrange(len(changed))] ^= 1 << chance.randrange(8)
    return bytes(changed)
