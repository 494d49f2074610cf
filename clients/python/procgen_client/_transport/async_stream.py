"""One learner's hold of one pool, as _stream.py, for asyncio."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import AsyncIterator, Callable
from typing import Any

import grpc
import grpc.aio

from procgen_client._proto import pools_pb2, step_pb2
from procgen_client._requests import Request
from procgen_client._transport.encoding import ObservationDecoder, decode_parts, decoder_for
from procgen_client._transport.stream import (
    BrokenConnectionError,
    Notices,
    attached_of,
    backoffs,
    check_answers,
    check_stands_where_left,
    is_broken_connection,
    not_made_again,
)
from procgen_client._transport.wire import Part
from procgen_client._validation import Expected
from procgen_client.errors import ProcgenError, UnavailableError, from_rpc_error


class AsyncStream:
    """Sends requests and receives their answers, in order, across broken connections.

    Tasks: one at a time. One that is cancelled while it waits ends the stream.

    Attributes:
        attached: What the server answered to the first attach.
    """

    attached: step_pb2.Attached

    def __init__(
        self,
        step_pool: Callable[..., Any],
        attach: step_pb2.Attach,
        pool: pools_pb2.Pool,
        reconnect_timeout: float,
    ) -> None:
        """For :meth:`open`."""
        self._pool = pool
        self._step_pool = step_pool
        self._reconnect_timeout = reconnect_timeout
        self._attach = attach
        self._attach.resumable = reconnect_timeout > 0
        self._unanswered: deque[Request] = deque()
        self._next_sequence_number = 0
        self._decoder: ObservationDecoder | None = None
        self._requests: asyncio.Queue[bytes] = asyncio.Queue()
        self._call: Any = None  # grpc's call of StepPool, which has no type of its own

    @classmethod
    async def open(
        cls,
        step_pool: Callable[..., Any],
        attach: step_pb2.Attach,
        pool: pools_pb2.Pool,
        reconnect_timeout: float,
    ) -> AsyncStream:
        """Attaches; arguments and errors as Stream's.

        Args:
            step_pool: Begins a call of StepPool, whose responses are read by _wire.
            attach: What to attach with.
            pool: The pool as it is known; the server must attach to one like it.
            reconnect_timeout: How long to try to go on after a broken connection, in seconds.
        """
        stream = cls(step_pool, attach, pool, reconnect_timeout)
        try:
            stream.attached = await stream._open()
            stream._decoder = decoder_for(stream.attached.pool)
        except BrokenConnectionError as broken:
            raise broken.error from None
        except BaseException:
            stream.drop()
            raise
        stream._next_sequence_number = stream.attached.next_sequence_number
        # Whoever has it when the connection breaks was this stream, as far as the server knows.
        stream._attach.take_over = True
        return stream

    @property
    def in_flight(self) -> int:
        """Number of requests whose answers were not received yet."""
        return len(self._unanswered)

    def send(self, body: bytes, expected: Expected | None) -> None:
        """Numbers a request and sends it; what goes wrong, receive tells."""
        request = Request.numbered(self._next_sequence_number, body, expected)
        self._next_sequence_number += 1
        self._unanswered.append(request)
        self._put(request)

    async def receive(self) -> list[Part]:
        """Waits for the answer to the oldest unanswered request; as Stream.receive."""
        while True:
            try:
                parts = await self._read_answer()
                if self._decoder is not None:
                    decode_parts(self._decoder, self._attach.pool, parts)
            except BrokenConnectionError as broken:
                await self._resume(broken.error)
            except BaseException:
                self.drop()
                raise
            else:
                self._unanswered.popleft()
                return parts

    def drop(self) -> None:
        """Ends the stream at once."""
        if self._call is not None:
            self._call.cancel()

    def _put(self, request: Request) -> None:
        self._requests.put_nowait(request.head + request.body)

    async def _read_answer(self) -> list[Part]:
        parts: list[Part] = []
        notices = Notices()
        while not parts or not parts[-1].last:
            response = await self._read()
            if notices.is_one(response):
                continue
            check_answers(response, self._unanswered[0], parts, self.attached)
            if not isinstance(response, Part):
                break
            parts.append(response)
        return parts

    async def _read(self) -> Part | step_pb2.StepPoolResponse:
        why: ProcgenError
        try:
            response = await self._call.read()
            if response is not grpc.aio.EOF:
                return response
            # The server took the connection's end for that of the stream.
            is_broken = True
            why = UnavailableError(f"the server ended the stream of {self._attach.pool}")
        except grpc.RpcError as error:
            is_broken = is_broken_connection(error)
            why = from_rpc_error(error)
        if is_broken and self._reconnect_timeout > 0:
            raise BrokenConnectionError(why)
        raise why

    async def _open(self, *, waits_for_server: bool = False) -> step_pb2.Attached:
        # Not by the call's write, which after the call's end waits until all of it is read.
        self._requests = asyncio.Queue()
        request = step_pb2.StepPoolRequest(attach=self._attach)
        self._requests.put_nowait(request.SerializeToString())
        self._call = self._step_pool(_each(self._requests), wait_for_ready=waits_for_server)
        return attached_of(await self._read(), self._attach, self._pool)

    async def _resume(self, error: ProcgenError) -> None:
        """Goes on with a new connection, or raises why that cannot be."""
        deadline = time.monotonic() + self._reconnect_timeout
        for delay in backoffs():
            self.drop()
            if time.monotonic() + delay >= deadline:
                raise not_made_again(self._reconnect_timeout, error)
            await asyncio.sleep(delay)
            try:
                attached = await asyncio.wait_for(
                    self._open(waits_for_server=True), deadline - time.monotonic()
                )
            except BrokenConnectionError as broken:
                error = broken.error
                continue
            except asyncio.TimeoutError:
                continue
            check_stands_where_left(attached, self._unanswered, self._next_sequence_number)
            for request in self._unanswered:
                self._put(request)
            return


async def _each(requests: asyncio.Queue[bytes]) -> AsyncIterator[bytes]:
    while True:
        yield await requests.get()
