"""The properties extension of dm_env_rpc: levels and states of the joined world."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from procgen_client._requests import LEVEL_SEEDS, in_range
from procgen_client.dm_env_rpc import _tensors
from procgen_client.dm_env_rpc._world import World
from procgen_client.errors import InvalidArgumentError, NotFoundError, PermissionDeniedError


class _Property(NamedTuple):
    """A property of each environment; that of environment I of a batch is "NAME.I"."""

    description: str
    dtype: type
    is_readable: bool
    is_writable: bool


_PROPERTIES = {
    "level_seed": _Property("Seed of the current level.", np.int32, True, False),
    "next_level_seed": _Property(
        "Seed of the next episode's level, in place of a drawn one.", np.int32, False, True
    ),
    "state": _Property(
        "Snapshot: the complete state. A written snapshot continues as the original would.",
        *(np.uint8, True, True),
    ),
}


def answer(request: Any, response: Any, world: World | None) -> None:  # noqa: ANN401 - messages
    """Fills the PropertyResponse of a PropertyRequest about the joined world.

    Raises:
        NotFoundError: There is no such property.
        PermissionDeniedError: It cannot be read, written or listed.
        InvalidArgumentError: A value has another type, shape or range.
        ProcgenError: As Pool.save_states and Pool.restore_states.
    """
    kind = request.WhichOneof("payload")
    if kind is None:
        raise InvalidArgumentError(
            "the PropertyRequest is empty, allowed: read_property, write_property, list_property"
        )
    asked = getattr(request, kind)
    getattr(response, kind).SetInParent()
    if kind == "list_property" and not asked.key:
        for name in _PROPERTIES if world is not None else ():
            _describe(name, world, response.list_property.values.add())
        return
    name, environment = _find(asked.key, world)
    assert world is not None  # Or there is no property.
    of = _PROPERTIES[name]
    length = world.length if environment is None else None
    if kind == "list_property":
        _require(length is not None, asked.key, "listed")
        for i in range(length or 0):
            _describe(f"{name}.{i}", world, response.list_property.values.add())
    elif kind == "read_property":
        _require(of.is_readable and (length is None or name != "state"), asked.key, "read")
        _tensors.pack(_value(name, environment, world), response.read_property.value)
    else:
        _require(of.is_writable and (length is None or name != "state"), asked.key, "written")
        _write(asked.key, name, environment, asked.value, world)


def _require(is_allowed: bool, key: str, verb: str) -> None:
    if not is_allowed:
        raise PermissionDeniedError(f"property '{key}' cannot be {verb}")


def _find(key: str, world: World | None) -> tuple[str, int | None]:
    """Returns the name of a property, and the index of an environment of a batch."""
    name, dot, index = key.partition(".")
    if world is not None and name in _PROPERTIES:
        if not dot:
            return name, None
        if world.length is not None and index in map(str, range(world.length)):
            return name, int(index)
    raise NotFoundError(f"there is no property '{key}' here")


def _describe(key: str, world: World | None, message: Any) -> None:  # noqa: ANN401 - PropertySpec
    name, environment = _find(key, world)
    assert world is not None
    of = _PROPERTIES[name]
    length = world.length if environment is None else None
    fits = length is None or name != "state"  # The lengths of states differ.
    message.spec.name, message.spec.dtype = key, _tensors.data_type(of.dtype)
    message.spec.shape.extend([] if length is None else [length])
    message.spec.shape.extend([_tensors.ANY] if name == "state" else [])
    message.is_readable, message.is_writable = of.is_readable and fits, of.is_writable and fits
    message.is_listable = length is not None
    message.description = of.description


def _value(name: str, environment: int | None, world: World) -> Any:  # noqa: ANN401
    if name == "state":
        return np.frombuffer(world.pool.save_states([environment or 0])[0], np.uint8)
    seeds = world.level_seeds()
    is_vector = environment is None and world.length is not None
    return seeds if is_vector else seeds[environment or 0]


def _write(
    key: str, name: str, environment: int | None, value: Any, world: World  # noqa: ANN401
) -> None:
    if name == "state":
        state = bytes(_tensors.unpack(key, value, _tensors.UINT8, _tensors.ANY))
        world.restore(environment or 0, state)
        return
    length = world.length if environment is None else None
    given = _tensors.unpack(key, value, _tensors.INTEGER, length)
    seeds = {environment or 0: given} if length is None else dict(enumerate(given))
    world.set_next_levels({i: in_range(key, seed, *LEVEL_SEEDS) for i, seed in seeds.items()})
