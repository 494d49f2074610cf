"""A raw HTTP/2 client that sends single frames, also ones that no gRPC library sends."""

from __future__ import annotations

import select
import socket
import struct
import time
from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

DATA, HEADERS, PRIORITY, RST_STREAM, SETTINGS, PING, GOAWAY, WINDOW_UPDATE, CONTINUATION = (
    0, 1, 2, 3, 4, 6, 7, 8, 9,
)  # fmt: skip
END_STREAM, ACK, END_HEADERS = 1, 1, 4
_CANCEL = 8
_HEADER_TABLE_SIZE, INITIAL_WINDOW_SIZE = 1, 4
_WINDOW = 65535
PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"


class Frame(NamedTuple):
    kind: int
    flags: int
    stream: int
    payload: bytes


def frame(kind: int, flags: int, stream: int, payload: bytes) -> bytes:
    return struct.pack(">I", len(payload))[1:] + struct.pack(">BBI", kind, flags, stream) + payload


def message(content: bytes) -> bytes:
    """A message with gRPC's length prefix."""
    return b"\0" + struct.pack(">I", len(content)) + content


def write_headers(headers: Iterable[tuple[str, str]]) -> bytes:
    """Returns a header block (RFC 7541) of literal fields without indexing."""
    return b"".join(b"\0" + _string(name) + _string(value) for name, value in headers)


def _string(text: str) -> bytes:
    length = len(text)
    if length < 0x7F:
        return bytes((length,)) + text.encode("ascii")
    head, length = bytearray((0x7F,)), length - 0x7F
    while length >= 0x80:
        head.append(length & 0x7F | 0x80)
        length >>= 7
    head.append(length)
    return bytes(head) + text.encode("ascii")


class Http2Connection:
    """A connection. Frames are buffered until flush()."""

    def __init__(
        self,
        address: str,
        *,
        wrap: Callable[[socket.socket], socket.socket] | None = None,
    ) -> None:
        """Connects to HOST:PORT; `wrap` adds TLS to the socket."""
        host, port = address.rsplit(":", 1)
        self.socket = socket.create_connection((host.strip("[]"), int(port)), 10)
        if wrap is not None:
            self.socket = wrap(self.socket)
        self.is_closed = False
        self.window = _WINDOW  # Send window of the connection, in bytes.
        self.stream_window = _WINDOW  # Initial send window of a stream.
        self.windows: dict[int, int] = {}
        self._last_stream = -1
        self._received = b""
        settings = struct.pack(">HIHI", _HEADER_TABLE_SIZE, 0, INITIAL_WINDOW_SIZE, 1 << 24)
        self.waiting = PREFACE + frame(SETTINGS, 0, 0, settings)

    def __enter__(self) -> Http2Connection:
        return self

    def __exit__(self, *_: object) -> None:
        self.socket.close()

    @staticmethod
    def block(method: str, metadata: Iterable[tuple[str, str]] = ()) -> bytes:
        """The header block of a call of `method`, "package.Service/Method"."""
        return write_headers([
            (":method", "POST"), (":scheme", "http"), (":path", f"/{method}"),
            (":authority", "server"), ("te", "trailers"), ("content-type", "application/grpc"),
            *metadata,
        ])  # fmt: skip

    def begin(self, method: str, metadata: Iterable[tuple[str, str]] = ()) -> int:
        """Starts a call. Returns its stream."""
        self._last_stream += 2
        self.windows[self._last_stream] = self.stream_window
        block = self.block(method, metadata)
        self.waiting += frame(HEADERS, END_HEADERS, self._last_stream, block)
        return self._last_stream

    def reset(self, stream: int) -> None:
        self.waiting += frame(RST_STREAM, 0, stream, struct.pack(">I", _CANCEL))

    def send(self, stream: int, content: bytes, *, ends: bool = False) -> None:
        """Sends bytes on a stream, regardless of its window."""
        self.waiting += frame(DATA, END_STREAM if ends else 0, stream, content)
        self.window -= len(content)
        self.windows[stream] -= len(content)

    def room(self, stream: int) -> int:
        return min(self.window, self.windows[stream], 16384)

    def flush(self, timeout: float = 10.0) -> None:
        """Sends the buffered frames. Sets is_closed if the server closed the connection."""
        waiting, self.waiting = self.waiting, b""
        self.socket.settimeout(timeout)
        try:
            self.socket.sendall(waiting)
        except OSError:
            self.is_closed = True

    def frames(self, timeout: float = 0.0) -> Iterator[Frame]:
        """Yields received frames; waits for the first bytes. Handles settings, pings, windows."""
        end = time.monotonic() + timeout
        self._receive(timeout)
        while True:
            while len(self._received) >= 9:
                length = int.from_bytes(self._received[:3], "big")
                if len(self._received) < 9 + length:
                    break
                kind, flags, stream = struct.unpack(">BBI", self._received[3:9])
                arrived = Frame(kind, flags, stream, self._received[9 : 9 + length])
                self._received = self._received[9 + length :]
                self._handle(arrived)
                yield arrived
            if self.is_closed or time.monotonic() >= end or not self._receive(0.0):
                break

    def awaits_end(self, stream: int, timeout: float = 30.0) -> bool:
        """Whether the server ends a call with trailers, within `timeout` seconds."""
        end = time.monotonic() + timeout
        while time.monotonic() < end and not self.is_closed:
            self.flush()
            for arrived in self.frames(0.1):
                if arrived.stream == stream and arrived.kind == HEADERS:
                    if arrived.flags & END_STREAM:
                        return True
        return False

    def awaits_close(self, timeout: float) -> bool:
        """Whether the server closes the connection within `timeout` seconds."""
        end = time.monotonic() + timeout
        while not self.is_closed and time.monotonic() < end:
            for _ in self.frames(0.1):
                pass
        return self.is_closed

    def _handle(self, arrived: Frame) -> None:
        if arrived.kind == SETTINGS and not arrived.flags & ACK:
            for at in range(0, len(arrived.payload), 6):
                name, value = struct.unpack_from(">HI", arrived.payload, at)
                if name == INITIAL_WINDOW_SIZE:
                    self.windows = {
                        stream: left + value - self.stream_window
                        for stream, left in self.windows.items()
                    }
                    self.stream_window = value
            self.waiting += frame(SETTINGS, ACK, 0, b"")
        elif arrived.kind == PING and not arrived.flags & ACK:
            self.waiting += frame(PING, ACK, 0, arrived.payload)
        elif arrived.kind == WINDOW_UPDATE:
            (more,) = struct.unpack(">I", arrived.payload)
            if arrived.stream == 0:
                self.window += more
            elif arrived.stream in self.windows:
                self.windows[arrived.stream] += more

    def _receive(self, timeout: float) -> bool:
        """Receives bytes; returns whether there were any."""
        if self.is_closed or not select.select([self.socket], [], [], timeout)[0]:
            return False
        try:
            self.socket.settimeout(5)
            some = self.socket.recv(1 << 18)
        except OSError:
            some = b""
        self.is_closed = not some
        self._received += some
        return bool(some)
