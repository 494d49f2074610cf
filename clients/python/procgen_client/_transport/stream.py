"""One learner's hold of one pool: the stream of StepPool, which outlives its connections."""

from __future__ import annotations

import random
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import Protocol

import grpc
from google.protobuf.message import DecodeError

from procgen_client._proto import pools_pb2, step_pb2
from procgen_client._requests import Request
from procgen_client._transport.encoding import decode_parts, decoder_for
from procgen_client._transport.pipe_transport import PipeTransport
from procgen_client._transport.shared_memory import SharedMapping
from procgen_client._transport.wire import Part, number_tag, read_response, varint
from procgen_client._validation import Expected, check_attached, check_part
from procgen_client.batch import Batch
from procgen_client.errors import (
    AbortedError,
    InternalError,
    ProcgenError,
    UnavailableError,
    from_rpc_error,
)

# Between tries to go on after a connection broke, in seconds: doubled from try to try, and each a
# half to one and a half of it, so that many learners do not come at once.
_BACKOFF_MIN = 0.02
_BACKOFF_MAX = 2.0
# A server that drains says so, and that it is not to be asked again.
_DRAINS_KEY = "procgen-drains"
# So many responses of kinds that are not known are ignored before an answer.
_NOTICES_MAX = 1000


_FIELDS = step_pb2.StepPoolRequest.DESCRIPTOR.fields_by_name
_ACKNOWLEDGED_TAG = number_tag(_FIELDS["acknowledged_sequence_number"].number)


class Call(Protocol):
    """A call of StepPool; ChannelCall, Http2Call."""

    def send(self, message: bytes) -> None:
        """Sends a message; that the call is over, only receive tells."""

    def end_requests(self) -> None:
        """Tells the server that no more messages come."""

    def receive(self) -> bytes | memoryview | None:
        """Waits for a message; None: the call has ended. Errors are grpc.RpcError."""

    def cancel(self) -> None:
        """Ends the call at once; from any thread."""


class BrokenConnectionError(Exception):
    """The call ended because its connection broke, not by an answer of the server."""

    def __init__(self, error: ProcgenError) -> None:
        super().__init__(str(error))
        self.error = error


class Stream:
    """Sends requests and receives their answers, in order.

    Where the connection breaks it attaches again and sends again what is unanswered, for at most
    ``reconnect_timeout`` seconds: the server keeps its answers meanwhile, so no step is lost or
    taken twice. After any other error the stream is over.

    Observations that the pool sends encoded are decoded.

    Threads: one at a time.

    Attributes:
        attached: What the server answered to the first attach.
        mapping: The memory that the pool shares. None: values are received.

    A pool that shares memory may offer a pipe transport, which bears the messages from then on; the
    call tells how the stream ended all the same.
    """

    def __init__(
        self,
        step_pool: Callable[[float | None], Call],
        attach: step_pb2.Attach,
        pool: pools_pb2.Pool,
        reconnect_timeout: float,
        mapping: SharedMapping | None = None,
    ) -> None:
        """Attaches.

        Args:
            step_pool: Begins a call of StepPool, with how long the server may be waited for, in
                seconds; None: not at all.
            attach: What to attach with; resumable is set here.
            pool: The pool as it is known; the server must attach to one like it.
            reconnect_timeout: How long to try to go on after a broken connection, in seconds. 0:
                not at all.
            mapping: The memory that the pool shares, if it was mapped before: what is held of it
                stays as it is.

        Raises:
            ProcgenError: What the server says, or that it cannot be reached.
            FailedPreconditionError: Shared memory cannot be mapped.
            InternalError: The server answers something else, or of another pool.
        """
        self.mapping = mapping
        self._pool = pool
        self._step_pool = step_pool
        self._reconnect_timeout = reconnect_timeout
        self._attach = step_pb2.Attach()
        self._attach.CopyFrom(attach)
        self._attach.resumable = reconnect_timeout > 0
        self._unanswered: deque[Request] = deque()
        self._call: Call | None = None
        self._pipes: PipeTransport | None = None  # None: the call bears the messages
        try:
            self.attached = self._open()
        except BrokenConnectionError as broken:
            raise broken.error from None
        # Of the whole stream: answers that are given again follow those that were decoded before
        # the connection broke.
        try:
            self._decoder = decoder_for(self.attached.pool)
        except ProcgenError:
            self.drop()
            raise
        self._next_sequence_number = self.attached.next_sequence_number
        # Whoever has it when the connection breaks was this stream, as far as the server knows.
        self._attach.take_over = True

    @property
    def in_flight(self) -> int:
        """Number of requests whose answers were not received yet."""
        return len(self._unanswered)

    def send(self, body: bytes, expected: Expected | None) -> int:
        """Numbers a request, sends it and gives its number.

        Args:
            body: A serialised StepPoolRequest that has only what is asked for.
            expected: What it is answered with; None: no values.
        """
        request = Request.numbered(self._next_sequence_number, body, expected)
        self._next_sequence_number += 1
        self._unanswered.append(request)
        self._put(request)
        return request.sequence_number

    def receive(self) -> Batch | list[Part]:
        """Waits for the answer to the oldest unanswered request.

        A batch, of a pool that shares memory; else one part or more. A request that has nothing to
        tell is answered by no part.

        Raises:
            DataLossError: Its observations are damaged. The stream is over.
            InternalError: It does not fit the request. The stream is over.
            ProcgenError: The stream is over.
        """
        while True:
            try:
                answer = self._read_answer(self._unanswered[0])
            except BrokenConnectionError as broken:
                self._resume(broken.error)
            else:
                if self._decoder is not None and not isinstance(answer, Batch):
                    self._decode(answer)
                self._unanswered.popleft()
                return answer

    def close(self) -> None:
        """Ends the stream; requests in flight are carried out, and their answers lost."""
        assert self._call is not None
        self._end_requests()
        try:
            while self._call.receive() is not None:  # Until the server has ended the stream.
                pass
        except grpc.RpcError:
            pass  # It has ended, too.
        except BaseException:
            self._call.cancel()
            raise

    def drop(self) -> None:
        """Ends the stream at once."""
        if self._pipes is not None:
            self._pipes.hang_up()
        if self._call is not None:
            self._call.cancel()

    def _put(self, request: Request) -> None:
        message = request.head + request.body
        if self.mapping is not None:
            # So that the batches of answers that have arrived are not kept for repetition.
            message += _ACKNOWLEDGED_TAG + varint(self._unanswered[0].sequence_number - 1)
            message += self.mapping.take_released()
        bearer = self._call if self._pipes is None else self._pipes
        assert bearer is not None
        bearer.send(message)

    def _end_requests(self) -> None:
        assert self._call is not None
        self._call.end_requests()
        if self._pipes is not None:
            self._pipes.hang_up()

    def _read_answer(self, request: Request) -> Batch | list[Part]:
        parts: list[Part] = []
        notices = Notices()
        while not parts or not parts[-1].last:
            message = self._next_message()
            try:
                if self.mapping is not None:
                    batch = self.mapping.read(bytes(message), request)
                    if batch is not None:
                        return batch
                response = self._read_response(message)
                if notices.is_one(response):
                    continue
                check_answers(response, request, parts, self.attached)
            except InternalError:
                self.drop()
                raise
            if not isinstance(response, Part):
                break
            parts.append(response)
        return parts

    def _decode(self, parts: list[Part]) -> None:
        """Decodes a whole answer: what was read of one whose connection broke comes again."""
        assert self._decoder is not None
        try:
            decode_parts(self._decoder, self._attach.pool, parts)
        except BaseException:  # Also Ctrl-C, say: what it has decoded it cannot decode again.
            self.drop()
            raise

    def _next_message(self) -> bytes | memoryview:
        assert self._call is not None
        try:
            message = None if self._pipes is None else self._pipes.receive()
            message = self._call.receive() if message is None else message
        except grpc.RpcError as error:
            is_broken = is_broken_connection(error)
            self.drop()
            if is_broken and self._reconnect_timeout > 0:
                raise BrokenConnectionError(from_rpc_error(error)) from None
            raise from_rpc_error(error) from None
        except BaseException:  # Ctrl-C, say: nobody can wait for another answer after that.
            self.drop()
            raise
        if message is not None:
            return message
        # The server took the connection's end for that of the stream.
        self.drop()
        ended = UnavailableError(f"the server ended the stream of {self._attach.pool}")
        if self._reconnect_timeout > 0:
            raise BrokenConnectionError(ended)
        raise ended

    def _read_response(self, message: bytes | memoryview) -> Part | step_pb2.StepPoolResponse:
        try:
            return read_response(message)
        except DecodeError as error:
            raise InternalError(f"{self._attach.pool} answered no message: {error}") from None

    def _open(self, timeout: float | None = None) -> step_pb2.Attached:
        self._pipes = None
        if self.mapping is not None:
            self._attach.held_batches[:] = self.mapping.take_held()
        attach = step_pb2.StepPoolRequest(attach=self._attach)
        self._call = self._step_pool(timeout)
        self._call.send(attach.SerializeToString())
        message = self._next_message()
        try:
            attached = attached_of(self._read_response(message), self._attach, self._pool)
            if attached.HasField("shared_memory"):
                self._map(attached.shared_memory)
        except ProcgenError:
            self.drop()
            raise
        if attached.HasField("shared_memory"):
            self._pipes = PipeTransport.open(
                attached.shared_memory.pipe_transport, attached.response_bytes_max
            )
        return attached

    def _map(self, memory: step_pb2.SharedMemory) -> None:
        if self.mapping is None:
            self.mapping = SharedMapping(memory, self._pool)
        elif self.mapping.path != memory.path:
            raise AbortedError(
                f"{self._attach.pool} shares {memory.path}, and what was attached to before shares "
                f"{self.mapping.path}: it is another pool of the same name"
            )
        elif self.mapping.batch_count != memory.batch_count:
            self.mapping.map_again(memory)

    def _resume(self, error: ProcgenError) -> None:
        """Goes on with a new connection, or raises why that cannot be."""
        deadline = time.monotonic() + self._reconnect_timeout
        for delay in backoffs():
            if time.monotonic() + delay >= deadline:
                raise not_made_again(self._reconnect_timeout, error)
            time.sleep(delay)
            try:
                attached = self._open_by(deadline)
            except BrokenConnectionError as broken:
                error = broken.error
                continue
            try:
                check_stands_where_left(attached, self._unanswered, self._next_sequence_number)
            except AbortedError:
                self.drop()
                raise
            for request in self._unanswered:
                self._put(request)
            return

    def _open_by(self, deadline: float) -> step_pb2.Attached:
        # Not the call's own timeout, which would be that of the whole stream.
        timeout = max(0.0, deadline - time.monotonic())
        timer = threading.Timer(timeout, self.drop)
        timer.daemon = True
        timer.start()
        try:
            return self._open(timeout)
        except ProcgenError as error:
            if time.monotonic() >= deadline:
                raise BrokenConnectionError(error) from None
            raise
        finally:
            timer.cancel()


def backoffs() -> Iterator[float]:
    """Gives how long to wait before each try to go on, in seconds."""
    backoff = _BACKOFF_MIN
    while True:
        yield backoff * random.uniform(0.5, 1.5)  # noqa: S311
        backoff = min(2 * backoff, _BACKOFF_MAX)


def not_made_again(timeout: float, error: ProcgenError) -> UnavailableError:
    """Gives what is told of a connection that cannot be made again in time."""
    return UnavailableError(
        f"the connection broke and could not be made again within {timeout:g} s: {error.message}"
    )


def attached_of(
    response: Part | step_pb2.StepPoolResponse, attach: step_pb2.Attach, pool: pools_pb2.Pool
) -> step_pb2.Attached:
    """Gives the answer to attach; InternalError if it is none to this one, of this pool."""
    if isinstance(response, Part) or response.WhichOneof("response") != "attached":
        raise InternalError(f"{attach.pool} answered something else than that it is attached")
    check_attached(response.attached, attach, pool)
    return response.attached


class Notices:
    """Responses of later servers' kinds that answer nothing: clients ignore those, to a degree."""

    def __init__(self) -> None:
        """None so far."""
        self._count = 0

    def is_one(self, response: Part | step_pb2.StepPoolResponse) -> bool:
        """Whether it is one; InternalError after many of them."""
        if (
            isinstance(response, Part)
            or response.WhichOneof("response") is not None
            or response.sequence_number
        ):
            return False
        self._count += 1
        if self._count > _NOTICES_MAX:
            raise InternalError(
                f"the server sends more than {_NOTICES_MAX} responses of unknown kinds, expected: "
                "an answer"
            )
        return True


def check_answers(
    response: Part | step_pb2.StepPoolResponse,
    request: Request,
    before: Sequence[Part],
    attached: step_pb2.Attached,
) -> None:
    """Checks that it answers this request, after the parts before; otherwise InternalError."""
    pool = attached.pool.name
    if response.sequence_number != request.sequence_number:
        raise InternalError(
            f"{pool} answered request {response.sequence_number}, where "
            f"{request.sequence_number} is next"
        )
    kind = "batch" if isinstance(response, Part) else response.WhichOneof("response")
    if kind != ("ack" if request.expected is None else "batch"):
        raise InternalError(
            f"{pool} answered request {request.sequence_number} with {kind}, expected: "
            f"{'ack' if request.expected is None else 'batch'}"
        )
    if isinstance(response, Part) and request.expected is not None:
        check_part(response, request.expected, before, attached)


def check_stands_where_left(
    attached: step_pb2.Attached, unanswered: Sequence[Request], next_sequence_number: int
) -> None:
    """Checks that nobody else has stepped the pool meanwhile; otherwise AbortedError."""
    stands_at = attached.next_sequence_number
    least = unanswered[0].sequence_number
    if not least <= stands_at <= next_sequence_number:
        raise AbortedError(
            f"{attached.pool.name} is at request {stands_at}, and this stream left it between "
            f"{least} and {next_sequence_number}: somebody else has stepped it, or it is another "
            "pool of the same name"
        )


def is_broken_connection(error: grpc.RpcError) -> bool:
    """Whether a call ended because its connection broke, not by an answer of the server."""
    if error.code() == grpc.StatusCode.UNAVAILABLE:
        return all(key != _DRAINS_KEY for key, _ in error.trailing_metadata() or ())
    # "Stream removed": gRPC's word where a socket was reset.
    return error.code() == grpc.StatusCode.UNKNOWN
