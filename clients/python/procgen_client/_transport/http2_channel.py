"""A channel for generated stubs that is made of Http2Calls, in place of grpcio's.

Each call has a connection of its own. There is nothing of gRPC's core in a process that has only
such channels, no thread and no file descriptor, so that it can fork.
"""

from __future__ import annotations

import time
import weakref
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import grpc
from google.protobuf.message import DecodeError

from procgen_client._transport.http2 import CallError, Http2Call
from procgen_client._transport.target import Target

# Between tries to connect to a server that is just starting.
_RETRY_SECONDS = 0.1

_Metadata = Sequence[tuple[str, str]]


class Http2Channel:
    """Calls to a server, without TLS.

    Threads: any method from any thread.
    """

    def __init__(self, target: Target) -> None:
        """Connects to nothing yet."""
        self._target = target
        self._calls: weakref.WeakSet[Http2Call] = weakref.WeakSet()

    def close(self) -> None:
        """Ends all calls with CANCELLED."""
        for call in list(self._calls):
            call.cancel()

    def stream_stream(
        self, method: str, metadata: _Metadata, connect_timeout: float | None
    ) -> Http2Call:
        """Begins a bidirectional call of messages as bytes."""
        return self._begin(method, metadata, connect_timeout=connect_timeout)

    def unary_unary(
        self,
        method: str,
        request_serializer: Callable[[Any], bytes],
        response_deserializer: Callable[[bytes], Any],
        **_: object,
    ) -> Callable[..., Any]:
        """Gives a method of a stub: it takes a request and gives the response."""

        def call(
            request: object,
            *,
            timeout: float | None = None,
            metadata: _Metadata = (),
            wait_for_ready: bool = False,
        ) -> Any:  # noqa: ANN401
            message = request_serializer(request)
            deadline = None if timeout is None else time.monotonic() + timeout
            while True:
                left = None if deadline is None else max(0.0, deadline - time.monotonic())
                try:
                    response = self._exchange(method, message, metadata, left)
                    return _read(response_deserializer, response)
                except CallError as error:
                    if not wait_for_ready or error.code() != grpc.StatusCode.UNAVAILABLE:
                        raise
                    if left is not None and left <= _RETRY_SECONDS:
                        code = grpc.StatusCode.DEADLINE_EXCEEDED
                        raise CallError(code, error.details()) from None
                time.sleep(_RETRY_SECONDS)

        return call

    def unary_stream(
        self,
        method: str,
        request_serializer: Callable[[Any], bytes],
        response_deserializer: Callable[[bytes], Any],
        **_: object,
    ) -> Callable[..., Any]:
        """Gives a method of a stub: it takes a request and gives an iterator that has cancel()."""

        def call(
            request: object, *, timeout: float | None = None, metadata: _Metadata = ()
        ) -> _Responses:
            begun = self._begin(method, metadata, timeout=timeout)
            begun.send(request_serializer(request))
            begun.end_requests()
            return _Responses(begun, response_deserializer)

        return call

    def _exchange(
        self, method: str, message: bytes, metadata: _Metadata, timeout: float | None
    ) -> bytes:
        call = self._begin(method, metadata, timeout=timeout)
        try:
            call.send(message)
            call.end_requests()
            response = call.receive()
            if response is None or call.receive() is not None:  # Which also raises its status.
                raise CallError(grpc.StatusCode.INTERNAL, f"{method} has not one response")
            return bytes(response)
        finally:
            call.cancel()

    def _begin(
        self,
        method: str,
        metadata: _Metadata,
        *,
        timeout: float | None = None,
        connect_timeout: float | None = None,
    ) -> Http2Call:
        call = Http2Call(self._target, method, metadata, connect_timeout, timeout)
        self._calls.add(call)
        return call


class _Responses:
    """The responses of a call, as they come."""

    def __init__(self, call: Http2Call, deserializer: Callable[[bytes], Any]) -> None:
        self._call = call
        self._deserializer = deserializer

    def __iter__(self) -> Iterator[Any]:
        return self

    def __next__(self) -> Any:  # noqa: ANN401
        message = self._call.receive()
        if message is None:
            raise StopIteration
        return _read(self._deserializer, bytes(message))

    def cancel(self) -> None:
        """Ends the call at once."""
        self._call.cancel()


def _read(deserializer: Callable[[bytes], Any], message: bytes) -> Any:  # noqa: ANN401
    try:
        return deserializer(message)
    except DecodeError as error:
        details = f"the server answers no message: {error}"
        raise CallError(grpc.StatusCode.INTERNAL, details) from None
