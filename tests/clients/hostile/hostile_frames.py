"""A connection on which a faulty or hostile server sends invalid HTTP/2, by mode.

A proxy between a learner and a real server. It forwards all bytes until a response of the stream
is due, and then sends what the mode defines.
"""

from __future__ import annotations

import random
import select
import socket
import struct
import threading
from collections.abc import Callable, Iterator

_DATA, _HEADERS, _RST_STREAM, _SETTINGS, _PING, _GOAWAY, _CONTINUATION = 0, 1, 3, 4, 6, 7, 9
_END_STREAM, _END_HEADERS = 1, 4
_HEADER_BYTES = 9
# In bytes. Responses with observations are larger than all others.
_PICTURES_BYTES = 50_000
# The disturbance replaces the next response with observations after this number of them.
_UNDISTURBED = 2
# After this silence within a message the server has no window left.
_STALL_SECONDS = 0.2
# In bytes. Limits the memory of the floods on the test's machine.
_FLOOD_BYTES = 32 * 1024 * 1024


def _frame(kind: int, flags: int, stream: int, payload: bytes) -> bytes:
    return struct.pack("!I", len(payload))[1:] + struct.pack("!BBI", kind, flags, stream) + payload


def _headers(*fields: tuple[bytes, bytes]) -> bytes:
    """A header block of literal fields, which need no earlier ones (RFC 7541, 6.2.2)."""
    return b"".join(
        b"\0" + bytes((len(name),)) + name + bytes((len(value),)) + value for name, value in fields
    )


def _trailers(stream: int, *fields: tuple[bytes, bytes]) -> bytes:
    return _frame(_HEADERS, _END_STREAM | _END_HEADERS, stream, _headers(*fields))


def _in_frames(stream: int, message: bytes) -> bytes:
    parts = [message[i : i + 16384] for i in range(0, len(message), 16384)]
    return b"".join(_frame(_DATA, 0, stream, part) for part in parts)


# By mode: the bytes that replace a response. Arguments: its stream and its bytes, including the
# five bytes of gRPC's prefix.
FRAMES: dict[str, Callable[[int, bytes], bytes]] = {
    "goaway_mid_message": lambda stream, message: (
        _in_frames(stream, message[:20000]) + _frame(_GOAWAY, 0, 0, struct.pack("!II", 0, 0))
    ),
    "goaway_with_an_error": lambda stream, _: _frame(
        _GOAWAY, 0, 0, struct.pack("!II", 0, 11) + b"too_many_pings"
    ),
    "reset_mid_message": lambda stream, message: (
        _in_frames(stream, message[:20000]) + _frame(_RST_STREAM, 0, stream, struct.pack("!I", 2))
    ),
    "reset_of_a_stream_that_is_none": lambda stream, message: (
        _frame(_RST_STREAM, 0, 1001, struct.pack("!I", 2)) + _in_frames(stream, message)
    ),
    "message_of_4_gib": lambda stream, message: _in_frames(
        stream, b"\0\xff\xff\xff\xf0" + message[5:]
    ),
    "message_longer_than_told": lambda stream, message: _in_frames(
        stream, b"\0\0\0\0\3" + message[5:]
    ),
    "message_marked_as_compressed": lambda stream, message: _in_frames(stream, b"\1" + message[1:]),
    "message_with_a_flag_that_is_none": lambda stream, message: _in_frames(
        stream, b"\x80" + message[1:]
    ),
    "trailers_mid_message": lambda stream, message: (
        _in_frames(stream, message[:20000]) + _trailers(stream, (b"grpc-status", b"0"))
    ),
    "trailers_with_status_that_is_none": lambda stream, _: _trailers(
        stream, (b"grpc-status", b"banana"), (b"grpc-message", b"%zz%")
    ),
    "trailers_with_status_of_many_digits": lambda stream, _: _trailers(
        stream, (b"grpc-status", b"9" * 60)
    ),
    "trailers_without_status": lambda stream, _: _trailers(stream, (b"x-what", b"nothing")),
    "trailers_with_bytes": lambda stream, _: _trailers(
        stream, (b"grpc-status", b"2"), (b"grpc-message", bytes(range(128, 250)))
    ),
    "headers_twice": lambda stream, message: (
        _frame(_HEADERS, _END_HEADERS, stream, _headers((b":status", b"404"))) * 3
        + _in_frames(stream, message)
    ),
    "headers_that_are_none": lambda stream, _: _frame(_HEADERS, 5, stream, b"\xff" * 300),
    "headers_without_end": lambda stream, _: (
        _frame(_HEADERS, 0, stream, _headers((b"a", b"b")))
        + _frame(_CONTINUATION, 0, stream, _headers((b"c", b"d" * 100)) * 150)
        * (_FLOOD_BYTES // 4 // 16000)
    ),
    "frame_of_16_mib": lambda stream, message: b"\xff\xff\xff\0\0" + struct.pack("!I", stream),
    "frame_of_a_kind_that_is_none": lambda stream, message: (
        _frame(0x77, 0xFF, stream, b"what") + _in_frames(stream, message)
    ),
    "settings_that_are_none": lambda stream, message: _frame(_SETTINGS, 0, 0, b"\0\1\2"),
    "settings_with_large_window": lambda stream, message: _frame(
        _SETTINGS, 0, 0, struct.pack("!HI", 4, 0xFFFFFFFF)
    ),
    "pings_in_plenty": lambda stream, message: (
        _frame(_PING, 0, 0, bytes(8)) * 20000 + _in_frames(stream, message)
    ),
    "data_without_content_in_plenty": lambda stream, message: (
        _frame(_DATA, 0, stream, b"") * 50000 + _in_frames(stream, message)
    ),
    "data_in_plenty": lambda stream, _: _in_frames(stream, bytes(_FLOOD_BYTES)),
    "noise": lambda stream, _: random.Random(7).randbytes(100_000),
    "end_mid_message": lambda stream, message: _in_frames(stream, message[:20000]),
}


class HostileConnection:
    """A proxy in front of a server; it listens at `address`."""

    def __init__(self, mode: str, target: str) -> None:
        """Starts listening."""
        self._disturb = FRAMES[mode]
        host, port = target.rsplit(":", 1)
        self._target = (host, int(port))
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self._listener.getsockname()[1]}"
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        while True:
            learner, _ = self._listener.accept()
            server = socket.create_connection(self._target)
            for run, ends in ((_pass_on, (learner, server)), (self._answer, (server, learner))):
                threading.Thread(target=run, args=ends, daemon=True).start()

    def _answer(self, server: socket.socket, learner: socket.socket) -> None:
        held: dict[int, bytes] = {}  # By stream: the received part of an incomplete message.
        passed_on: dict[int, int] = {}  # By stream: remaining bytes of a message that is forwarded.
        pictures = 0
        try:
            for arrived in _frames_of(server):
                if arrived is None:
                    # The window is exhausted; the learner extends it when it receives data.
                    for stream in [stream for stream, part in held.items() if len(part) >= 5]:
                        part = held.pop(stream)
                        passed_on[stream] = 5 + int.from_bytes(part[1:5], "big") - len(part)
                        learner.sendall(_in_frames(stream, part))
                    continue
                head, payload = arrived
                stream = int.from_bytes(head[5:], "big")
                if head[3] != _DATA or stream in passed_on:
                    learner.sendall(head + payload)
                    if head[3] == _DATA:
                        passed_on[stream] -= len(payload)
                        if passed_on[stream] <= 0:
                            del passed_on[stream]
                    continue
                message = held.pop(stream, b"") + payload
                if len(message) < 5 or len(message) < 5 + int.from_bytes(message[1:5], "big"):
                    held[stream] = message
                    continue
                pictures += len(message) > _PICTURES_BYTES
                if pictures > _UNDISTURBED and len(message) > _PICTURES_BYTES:
                    learner.sendall(self._disturb(stream, message))
                    # Gives the learner time to detect the disturbance.
                    learner.settimeout(0.5)
                    break
                learner.sendall(_in_frames(stream, message))
        except (OSError, ValueError):
            pass  # One of both has closed its connection.
        _end(server)
        try:
            learner.shutdown(socket.SHUT_WR)
        except OSError:
            pass


def _frames_of(server: socket.socket) -> Iterator[tuple[bytes, bytes] | None]:
    """Yields headers and payloads of frames, and None after a silence."""
    received = b""
    while True:
        while len(received) >= _HEADER_BYTES:
            end = _HEADER_BYTES + int.from_bytes(received[:3], "big")
            if len(received) < end:
                break
            yield received[:_HEADER_BYTES], received[_HEADER_BYTES:end]
            received = received[end:]
        if not select.select([server], [], [], _STALL_SECONDS)[0]:
            yield None
            continue
        content = server.recv(65536)
        if not content:
            return
        received += content


def _pass_on(learner: socket.socket, server: socket.socket) -> None:
    try:
        while content := learner.recv(65536):
            server.sendall(content)
    except OSError:
        pass
    _end(server)
    _end(learner)


def _end(connection: socket.socket) -> None:
    try:
        connection.shutdown(socket.SHUT_RDWR)
    except OSError:
        pass
