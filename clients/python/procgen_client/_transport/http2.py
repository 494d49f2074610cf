"""A call of gRPC on a connection of its own, in HTTP/2 without TLS, for pictures.

grpcio copies each message three times on its way to Python, and has it pass from thread to thread.
Here the thread that waits for a message receives it, from the socket into the array that it stays
in. What is spoken is HTTP/2 (RFC 9113), as gRPC does; calls with TLS or by way of a proxy, and all
that is no stream of pictures, are grpcio's.
"""

from __future__ import annotations

import select
import socket
import struct
import threading
import time
import urllib.parse
import weakref
from collections import deque
from collections.abc import Sequence

import grpc
import numpy as np

from procgen_client import _fork
from procgen_client._transport.hpack import HeaderError, read_headers, write_headers
from procgen_client._transport.target import Target

_PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
_FRAME_HEADER_BYTES = 9
_MESSAGE_HEADER_BYTES = 5
_STREAM = 1  # The connection has one.

# Types of frames, flags and settings.
_DATA, _HEADERS, _RST_STREAM, _SETTINGS, _PING, _GOAWAY, _WINDOW_UPDATE, _CONTINUATION = (
    0, 1, 3, 4, 6, 7, 8, 9
)  # fmt: skip
_ACK = _END_STREAM = 0x1
_END_HEADERS, _PADDED, _PRIORITY = 0x4, 0x8, 0x20
_HEADER_TABLE_SIZE, _ENABLE_PUSH, _INITIAL_WINDOW_SIZE, _MAX_FRAME_SIZE = 1, 2, 4, 5

# The server need not wait for a word of this side: requests are what asks for answers.
_WINDOW_MAX = (1 << 31) - 1
_WINDOW_DEFAULT = (1 << 16) - 1
_WINDOW_UPDATE_BYTES = 1 << 30
_FRAME_BYTES_MAX = (1 << 24) - 1
_SENT_FRAME_BYTES_MAX = 1 << 14
# Largest message that is received. Attach says how large responses may be, and far less is usual;
# this bounds what a faulty server can make this process take.
MESSAGE_BYTES_MAX = 256 * 1024 * 1024
# Of all but messages: headers and what else is some bytes.
_SMALL_FRAME_BYTES_MAX = 1 << 16
# For all but pictures, which are received where they stay.
_BUFFER_BYTES = 1 << 14

_CONNECT_SECONDS = 20
# A server that says nothing for so long is asked for a sign of life, and is gone after as long.
_SILENCE_SECONDS = 20
# How often is looked, while nobody waits for a message, whether the server asks for one.
_KEEPER_SECONDS = 5


_STATUS_CODES = {code.value[0]: code for code in grpc.StatusCode}
_RESET_CODES = {
    7: grpc.StatusCode.UNAVAILABLE,  # REFUSED_STREAM
    8: grpc.StatusCode.CANCELLED,  # CANCEL
    11: grpc.StatusCode.RESOURCE_EXHAUSTED,  # ENHANCE_YOUR_CALM
}
_HTTP_CODES = {
    "400": grpc.StatusCode.INTERNAL,
    "401": grpc.StatusCode.UNAUTHENTICATED,
    "403": grpc.StatusCode.PERMISSION_DENIED,
    "404": grpc.StatusCode.UNIMPLEMENTED,
    "429": grpc.StatusCode.UNAVAILABLE,
    "502": grpc.StatusCode.UNAVAILABLE,
    "503": grpc.StatusCode.UNAVAILABLE,
    "504": grpc.StatusCode.UNAVAILABLE,
}


class CallError(grpc.RpcError):
    """A call that has ended otherwise than with OK, with the methods of grpcio's errors."""

    def __init__(
        self,
        code: grpc.StatusCode,
        details: str,
        trailing_metadata: Sequence[tuple[str, str]] = (),
    ) -> None:
        """Takes what the methods give."""
        super().__init__(details)
        self._code = code
        self._details = details
        self._trailing_metadata = tuple(trailing_metadata)

    def code(self) -> grpc.StatusCode:
        """Gives the status."""
        return self._code

    def details(self) -> str:
        """Gives what the server says of it."""
        return self._details

    def trailing_metadata(self) -> tuple[tuple[str, str], ...]:
        """Gives what came with it."""
        return self._trailing_metadata


class Http2Call:
    """A bidirectional call.

    While nobody waits for a message a thread answers the server's questions for a sign of life.

    Threads: one at a time; cancel from any.
    """

    def __init__(
        self,
        target: Target,
        method: str,
        metadata: Sequence[tuple[str, str]],
        connect_timeout: float | None = None,
        timeout: float | None = None,
    ) -> None:
        """Connects and begins the call; that it could not, receive tells.

        Args:
            target: Where to.
            method: The method's path.
            metadata: What the call bears.
            connect_timeout: How long to wait for a connection, in seconds, if less than usual.
            timeout: How long the call may take, in seconds. None: for ever.
        """
        self._lock = threading.Lock()
        self._over = threading.Event()  # Set by _end alone.
        self._error: CallError | None = None  # With _over: None is OK.
        self._is_given_up = False
        self._buffer = bytearray(_BUFFER_BYTES)  # Received: [_unread_begin, _unread_end).
        self._view = memoryview(self._buffer)
        self._unread_begin = self._unread_end = 0
        self._message_header = b""  # As far as it has come.
        self._message: memoryview | None = None  # What comes after it: [0, _filled) is there.
        self._filled = 0
        self._messages: deque[memoryview] = deque()
        self._http_status = ""
        self._unconfirmed_bytes = 0  # Received, and the windows not opened for as many yet.
        self._connection_window = self._stream_window = _WINDOW_DEFAULT  # For what is sent.
        self._initial_window = _WINDOW_DEFAULT
        self._deadline: float | None = None
        self._was_asked = False  # For a sign of life, since the last one.
        self._socket: socket.socket | None = None
        _fork.bind(self)
        self._address = target.authority if target.path is None else f"unix:{target.path}"
        headers = [
            (":method", "POST"),
            (":scheme", "http"),
            (":path", method),
            (":authority", target.authority),
            ("te", "trailers"),
            ("content-type", "application/grpc"),
            ("user-agent", "procgen-client-python"),
            *metadata,
        ]
        silence_seconds: float = _SILENCE_SECONDS
        if timeout is not None:
            self._deadline = time.monotonic() + timeout
            headers.append(("grpc-timeout", f"{max(1, min(10**8 - 1, int(timeout * 1000)))}m"))
            silence_seconds = min(silence_seconds, max(timeout, 0.001))
            connect_timeout = timeout
        try:
            wait = _CONNECT_SECONDS if connect_timeout is None else connect_timeout
            self._socket = target.connect(min(max(wait, 0.001), _CONNECT_SECONDS))
            # Python's own timeout would cost a system call more each time.
            seconds = int(silence_seconds)
            silence = struct.pack("ll", seconds, int((silence_seconds - seconds) * 1e6))
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, silence)
        except OSError as error:
            self._end_broken(str(error))
            return
        head = _frame(_HEADERS, _END_HEADERS, _STREAM, write_headers(headers))
        self._send_bytes(_BEGINNING + head)
        if timeout is not None:
            return  # It is waited for at once.
        threading.Thread(
            target=_keep, args=(weakref.ref(self), self._over), name="procgen-keeper", daemon=True
        ).start()

    def __del__(self) -> None:
        """Ends the call."""
        self._over.set()
        if self._socket is not None:
            self._socket.close()

    def send(self, message: bytes) -> None:
        """Sends a message; that the call is over, only receive tells."""
        with self._lock:
            try:
                self._send_content(struct.pack("!BI", 0, len(message)) + message, 0)
            except BaseException:  # Ctrl-C, say: how much of it was sent nobody knows.
                self._end_broken("a request was interrupted")
                raise

    def end_requests(self) -> None:
        """Tells the server that no more messages come."""
        with self._lock:
            self._send_content(b"", _END_STREAM)

    def receive(self) -> memoryview | None:
        """Waits for the next message, which is read-only. None: the call has ended with OK.

        Raises:
            CallError: It has ended otherwise.
        """
        with self._lock:
            while not self._messages:
                if self._over.is_set():
                    if self._error is not None:
                        raise self._error
                    return None
                self._read_frame()
            return self._messages.popleft()

    def cancel(self) -> None:
        """Ends the call at once."""
        self._is_given_up = True
        connection = self._socket
        if connection is not None:
            try:
                connection.shutdown(socket.SHUT_RDWR)  # Who waits for a message wakes up.
            except OSError:
                pass  # It is closed already.
        if self._lock.acquire(blocking=False):  # Otherwise who has it finds the end.
            try:
                self._end_broken("")
            finally:
                self._lock.release()

    def abandon(self) -> None:
        """In a forked child: leaves the connection to the parent, whose threads may hold locks."""
        self._lock = threading.Lock()
        self._over = threading.Event()
        self._end_broken("belongs to the process that this one was forked from")

    def keep(self) -> None:
        """Reads what has come, unless somebody does."""
        if self._lock.acquire(blocking=False):
            try:
                while self._socket is not None and (
                    self._unread_begin < self._unread_end
                    or select.select([self._socket], [], [], 0)[0]
                ):
                    self._read_frame()
            finally:
                self._lock.release()

    # Sending.

    def _send_bytes(self, frames: bytes) -> None:
        if self._socket is None:
            return
        try:
            self._socket.sendall(frames)
        except OSError as error:
            self._end_broken(str(error))

    def _send_content(self, content: bytes, flags: int) -> None:
        position = 0
        while not self._over.is_set():
            room = min(_SENT_FRAME_BYTES_MAX, self._connection_window, self._stream_window)
            size = max(0, min(len(content) - position, room))
            if not size and content:
                self._read_frame()  # Until the server has room.
                continue
            self._connection_window -= size
            self._stream_window -= size
            chunk = content[position : position + size]
            position += size
            is_last = position == len(content)
            self._send_bytes(_frame(_DATA, flags if is_last else 0, _STREAM, chunk))
            if is_last:
                return

    # Receiving.

    def _read_frame(self) -> None:
        """Waits for a frame and takes it in; any error ends the call."""
        try:
            head = self._take(_FRAME_HEADER_BYTES)
            length = int.from_bytes(head[:3], "big")
            if head[3] == _DATA:
                self._read_content(length, head[4])
            elif length > _SMALL_FRAME_BYTES_MAX:
                raise ValueError(f"a frame of type {head[3]} and {length} bytes")
            else:
                stream = int.from_bytes(head[5:], "big") & _WINDOW_MAX
                self._read_other(head[3], head[4], stream, self._take(length))
        except OSError as error:
            self._end_broken(str(error))
        except (HeaderError, struct.error, ValueError, IndexError) as error:
            self._end(CallError(grpc.StatusCode.INTERNAL, f"{self._address} answered: {error}"))

    def _read_content(self, length: int, flags: int) -> None:
        self._confirm(length)
        padding = 0
        if flags & _PADDED:
            padding = self._take(1)[0]
            length -= 1 + padding
        while length > 0:
            if self._message is None:
                part = self._take(min(_MESSAGE_HEADER_BYTES - len(self._message_header), length))
                self._message_header += part
                length -= len(part)
                if len(self._message_header) < _MESSAGE_HEADER_BYTES:
                    break
                is_compressed, size = struct.unpack("!BI", self._message_header)
                if is_compressed:
                    raise ValueError("a compressed message, which nobody has asked for")
                if size > MESSAGE_BYTES_MAX:
                    raise ValueError(
                        f"a message of {size} bytes, expected: up to {MESSAGE_BYTES_MAX}"
                    )
                self._message = np.empty(size, np.uint8).data
                self._filled = 0
            # Of the message, or of the frame.
            rest = self._message[self._filled : self._filled + length]
            self._fill(rest)
            self._filled += len(rest)
            length -= len(rest)
            if self._filled == len(self._message):
                self._messages.append(self._message.toreadonly())
                self._message, self._message_header = None, b""
        self._take(padding)
        if flags & _END_STREAM:
            raise ValueError("an end without a status")

    def _read_other(self, kind: int, flags: int, stream: int, payload: bytes) -> None:
        if kind == _HEADERS:
            self._read_headers(flags, payload)
        elif kind == _SETTINGS and not flags & _ACK:
            self._read_settings(payload)
        elif kind == _PING and not flags & _ACK:
            self._send_bytes(_frame(_PING, _ACK, 0, payload))
        elif kind == _WINDOW_UPDATE and stream == 0:
            self._connection_window += int.from_bytes(payload, "big")
        elif kind == _WINDOW_UPDATE:
            self._stream_window += int.from_bytes(payload, "big")
        elif kind == _RST_STREAM:
            code = int.from_bytes(payload, "big")
            status = _RESET_CODES.get(code, grpc.StatusCode.INTERNAL)
            self._end(CallError(status, f"{self._address} has reset the stream (code {code})"))
        elif kind == _GOAWAY and int.from_bytes(payload[:4], "big") & _WINDOW_MAX < _STREAM:
            self._end_broken("the server goes away")

    def _read_headers(self, flags: int, payload: bytes) -> None:
        begin = (1 if flags & _PADDED else 0) + (5 if flags & _PRIORITY else 0)
        block = payload[begin : len(payload) - (payload[0] if flags & _PADDED else 0)]
        is_whole = flags & _END_HEADERS
        while not is_whole:
            head = self._take(_FRAME_HEADER_BYTES)
            if head[3] != _CONTINUATION:
                raise ValueError(f"a frame of type {head[3]} within headers")
            block += self._take(int.from_bytes(head[:3], "big"))
            if len(block) > _SMALL_FRAME_BYTES_MAX:
                raise ValueError(f"headers of more than {_SMALL_FRAME_BYTES_MAX} bytes")
            is_whole = head[4] & _END_HEADERS
        headers = read_headers(block)
        self._http_status = dict(headers).get(":status", self._http_status)
        if flags & _END_STREAM:
            self._end(self._error_of(headers))

    def _error_of(self, trailers: list[tuple[str, str]]) -> CallError | None:
        told = dict(trailers)
        if "grpc-status" not in told:
            code = _HTTP_CODES.get(self._http_status, grpc.StatusCode.UNKNOWN)
            return CallError(code, f"{self._address} answers with HTTP status {self._http_status}")
        code = _STATUS_CODES.get(int(told["grpc-status"]), grpc.StatusCode.UNKNOWN)
        if code == grpc.StatusCode.OK:
            return None
        return CallError(code, urllib.parse.unquote(told.get("grpc-message", "")), trailers)

    def _read_settings(self, payload: bytes) -> None:
        for name, value in struct.iter_unpack("!HI", payload):
            if name == _INITIAL_WINDOW_SIZE:
                self._stream_window += value - self._initial_window
                self._initial_window = value
        self._send_bytes(_frame(_SETTINGS, _ACK, 0, b""))

    def _confirm(self, size: int) -> None:
        """Opens the windows again, long before they are closed."""
        self._unconfirmed_bytes += size
        if self._unconfirmed_bytes >= _WINDOW_UPDATE_BYTES:
            opened = _number(self._unconfirmed_bytes)
            self._unconfirmed_bytes = 0
            self._send_bytes(
                _frame(_WINDOW_UPDATE, 0, 0, opened) + _frame(_WINDOW_UPDATE, 0, _STREAM, opened)
            )

    def _take(self, size: int) -> bytes:
        """Waits for so many bytes."""
        if size <= self._unread_end - self._unread_begin:
            taken = bytes(self._view[self._unread_begin : self._unread_begin + size])
            self._unread_begin += size
            return taken
        taken_whole = bytearray(size)
        self._fill(memoryview(taken_whole))
        return bytes(taken_whole)

    def _fill(self, place: memoryview) -> None:
        """Waits for as many bytes as `place` has; what comes after them goes to the buffer."""
        filled = min(len(place), self._unread_end - self._unread_begin)
        place[:filled] = self._view[self._unread_begin : self._unread_begin + filled]
        self._unread_begin += filled
        while filled < len(place):
            count = self._receive_into(place[filled:])
            filled += count
            if filled > len(place):
                self._unread_begin, self._unread_end = 0, filled - len(place)

    def _receive_into(self, place: memoryview) -> int:
        while True:
            if self._socket is None:
                raise ConnectionError("the call is over")
            try:
                count = self._socket.recvmsg_into([place, self._view])[0]
            except BlockingIOError:
                if self._deadline is not None and time.monotonic() > self._deadline - 0.01:
                    code = grpc.StatusCode.DEADLINE_EXCEEDED
                    self._end(CallError(code, f"{self._address} has not answered in time"))
                    raise TimeoutError from None
                if self._was_asked:
                    raise TimeoutError(f"silent for {2 * _SILENCE_SECONDS} s") from None
                self._was_asked = True
                self._send_bytes(_frame(_PING, 0, 0, bytes(8)))
                continue
            if not count:
                raise ConnectionError("the server has closed the connection")
            self._was_asked = False
            return count

    # The end.

    def _end_broken(self, why: str) -> None:
        if self._is_given_up:
            self._end(CallError(grpc.StatusCode.CANCELLED, "the call was given up"))
        else:
            message = f"the connection to {self._address}: {why}"
            self._end(CallError(grpc.StatusCode.UNAVAILABLE, message))

    def _end(self, error: CallError | None) -> None:
        """Ends the call, as what it ended with first."""
        if self._over.is_set():
            return
        self._error = error
        self._over.set()
        connection, self._socket = self._socket, None
        if connection is not None:
            connection.close()


def _keep(reference: weakref.ref[Http2Call], over: threading.Event) -> None:
    while not over.wait(_KEEPER_SECONDS):
        call = reference()
        if call is None:
            return
        call.keep()
        del call


def _frame(kind: int, flags: int, stream: int, payload: bytes) -> bytes:
    return len(payload).to_bytes(3, "big") + struct.pack("!BBI", kind, flags, stream) + payload


def _number(value: int) -> bytes:
    return value.to_bytes(4, "big")


# What a connection begins with.
_BEGINNING = (
    _PREFACE
    + _frame(
        _SETTINGS,
        0,
        0,
        struct.pack(
            "!HIHIHIHI",
            *(_HEADER_TABLE_SIZE, 0, _ENABLE_PUSH, 0),
            *(_INITIAL_WINDOW_SIZE, _WINDOW_MAX, _MAX_FRAME_SIZE, _FRAME_BYTES_MAX),
        ),
    )
    + _frame(_WINDOW_UPDATE, 0, 0, _number(_WINDOW_MAX - _WINDOW_DEFAULT))
)
