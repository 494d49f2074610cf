"""The worlds, and the streams of dm_env_rpc that use them."""

from __future__ import annotations

import threading
from typing import Any

from dm_env_rpc.v1 import dm_env_rpc_pb2 as pb2
from dm_env_rpc.v1.extensions import properties_pb2
from google.protobuf.message import DecodeError

from procgen_client.client import Client
from procgen_client.dm_env_rpc import _properties
from procgen_client.dm_env_rpc._settings import pool_arguments
from procgen_client.dm_env_rpc._world import World
from procgen_client.errors import (
    FailedPreconditionError,
    InvalidArgumentError,
    NotFoundError,
    ProcgenError,
    StatusCode,
    UnimplementedError,
    UnknownOptionError,
)
from procgen_client.pool import Pool

# Errors repeat names of the caller.
_MESSAGE_LENGTH_MAX = 600


class Worlds:
    """The worlds of all streams, by name. `lock` guards them, and which stream has joined each."""

    def __init__(self, client: Client | None) -> None:
        """Takes the server of the pools; None: this process."""
        self.lock = threading.Lock()
        self.client = client
        self.by_name: dict[str, World] = {}
        self.created_count = 0

    def close(self) -> None:
        """Destroys all worlds. No stream may use them."""
        while self.by_name:
            self.by_name.popitem()[1].pool.close()


class Session:
    """Answers the requests of a stream, one at a time. An error changes nothing."""

    def __init__(self, worlds: Worlds) -> None:
        """Takes the worlds of all streams."""
        self._worlds = worlds
        self._joined: World | None = None

    def answer(self, data: bytes) -> Any:  # noqa: ANN401 - a message
        """Returns the EnvironmentResponse of an EnvironmentRequest."""
        response = pb2.EnvironmentResponse()
        try:
            request = _parsed(pb2.EnvironmentRequest(), data, "request")
            kind = request.WhichOneof("payload")
            if kind is None:
                kinds = ", ".join(pb2.EnvironmentRequest.DESCRIPTOR.fields_by_name)
                raise InvalidArgumentError(f"the request is empty, allowed: {kinds}")
            getattr(response, kind).SetInParent()
            getattr(self, f"_{kind}")(getattr(request, kind), getattr(response, kind))
        except ProcgenError as error:
            _set_error(response, error.code, error.message)
        except Exception as error:  # Such as no memory for a large world.
            _set_error(response, StatusCode.INTERNAL, f"{type(error).__name__}: {error}")
        return response

    def end(self) -> None:
        """Leaves the joined world, if there is one."""
        if self._joined is not None:
            with self._worlds.lock:
                self._joined.session = None
            self._joined = None

    def _world(self) -> World:
        if self._joined is None:
            raise FailedPreconditionError("no world is joined; join one first")
        return self._joined

    def _find(self, name: str, verb: str) -> World:
        """Returns a world that no other stream has joined; `lock` is held."""
        world = self._worlds.by_name.get(name)
        if world is None:
            raise NotFoundError(f"there is no world {name}")
        if world.session not in (None, self):
            raise FailedPreconditionError(
                f"world {name} is joined by another stream and cannot be {verb}: send LeaveWorld "
                "there or end that stream, or create another world"
            )
        return world

    def _create_world(self, request: Any, response: Any) -> None:  # noqa: ANN401
        worlds = self._worlds
        pool = Pool(**pool_arguments(request.settings), server=worlds.client)
        with worlds.lock:
            worlds.created_count += 1
            name = pool.name or f"worlds/{worlds.created_count}"
            worlds.by_name[name] = World(name, pool)
        response.world_name = name

    def _join_world(self, request: Any, response: Any) -> None:  # noqa: ANN401
        for name in request.settings:
            raise UnknownOptionError(f"join_world has no option '{name}'; it has none")
        if self._joined is not None:
            raise FailedPreconditionError("a world is joined; leave it before another is joined")
        with self._worlds.lock:
            world = self._find(request.world_name, "joined")
            world.session = self
        self._joined = world
        response.specs.CopyFrom(world.join())

    def _step(self, request: Any, response: Any) -> None:  # noqa: ANN401
        self._world().step(request, response)

    def _reset(self, request: Any, response: Any) -> None:  # noqa: ANN401
        self._world().reset(request.settings)
        response.specs.CopyFrom(self._world().specs())

    def _reset_world(self, request: Any, response: Any) -> None:  # noqa: ANN401
        with self._worlds.lock:
            self._find(request.world_name, "reset").reset(request.settings)

    def _leave_world(self, request: Any, response: Any) -> None:  # noqa: ANN401
        self.end()

    def _destroy_world(self, request: Any, response: Any) -> None:  # noqa: ANN401
        with self._worlds.lock:
            world = self._find(request.world_name, "destroyed")
            if world.session is self:
                raise FailedPreconditionError(
                    f"world {world.name} is joined by this stream: leave it first"
                )
            del self._worlds.by_name[world.name]
        world.pool.close()

    def _extension(self, request: Any, response: Any) -> None:  # noqa: ANN401
        of = properties_pb2.PropertyRequest.DESCRIPTOR
        if not request.Is(of):
            raise UnimplementedError(
                f"the extension has type {request.type_url}, offered: {of.full_name}"
            )
        asked = _parsed(properties_pb2.PropertyRequest(), request.value, "extension")
        answer = properties_pb2.PropertyResponse()
        _properties.answer(asked, answer, self._joined)
        response.Pack(answer)


def _parsed(message: Any, data: bytes, name: str) -> Any:  # noqa: ANN401
    try:
        message.ParseFromString(data)
    except DecodeError:
        raise InvalidArgumentError(
            f"the {name}'s {len(data)} bytes are not a valid {message.DESCRIPTOR.full_name}"
        ) from None
    return message


def _set_error(response: Any, code: StatusCode, message: str) -> None:  # noqa: ANN401
    response.Clear()
    response.error.code = int(code)
    cut = message[:_MESSAGE_LENGTH_MAX]
    response.error.message = cut + "..." * (len(cut) < len(message))
