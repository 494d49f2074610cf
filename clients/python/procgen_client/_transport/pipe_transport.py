"""A stream's messages past gRPC: the learner's side of procgen.v1.PipeTransport."""

from __future__ import annotations

import os
import socket
import stat
import struct
from typing import BinaryIO

from procgen_client import _fork
from procgen_client._proto import step_pb2
from procgen_client.errors import InternalError

_LENGTH = struct.Struct("=I")
# Answers of shared memory have some tens of bytes.
_RECEIVE_BYTES = 1 << 12
# How long a server may take to answer at its socket.
_ANSWER_SECONDS = 2.0


class PipeTransport:
    """Two pipes that bear the messages of a stream whose pool shares memory.

    Threads: one may send while another receives.
    """

    @classmethod
    def open(cls, offer: step_pb2.PipeTransport, response_bytes_max: int) -> PipeTransport | None:
        """Connects; None: that cannot be done from here, and gRPC's stream does as well."""
        with socket.socket(socket.AF_UNIX) as connection:
            connection.settimeout(_ANSWER_SECONDS)
            try:
                connection.connect("\0" + offer.socket_name)
                connection.sendall(offer.key)
                _, ends, _, _ = socket.recv_fds(connection, 1, 2)
                for end in ends:
                    os.set_inheritable(end, False)
                requests, responses = ends
                if not all(stat.S_ISFIFO(os.fstat(end).st_mode) for end in ends):
                    for end in ends:
                        os.close(end)
                    return None
            except (OSError, ValueError):  # There is nobody, or nobody who knows the key.
                return None
        return cls(
            os.fdopen(requests, "wb", buffering=0),
            os.fdopen(responses, "rb", buffering=0),
            response_bytes_max,
        )

    def __init__(self, requests: BinaryIO, responses: BinaryIO, response_bytes_max: int) -> None:
        """Takes over the learner's ends of the pipes."""
        self._response_bytes_max = response_bytes_max
        self._requests = requests
        self._responses = responses
        self._received = b""
        _fork.bind(self)

    def send(self, message: bytes) -> None:
        """Sends a serialised request; that the pipes have ended, only receive finds."""
        left = _LENGTH.pack(len(message)) + message
        try:
            while left:
                left = left[self._requests.write(left) :]
        except (OSError, ValueError):  # It has ended, or this side has hung up.
            pass

    def receive(self) -> bytes | None:
        """Waits for the next serialised response. None: the pipes have ended."""
        while True:
            received = self._received
            if len(received) >= _LENGTH.size:
                length = _LENGTH.unpack_from(received)[0]
                if length > self._response_bytes_max:
                    raise InternalError(
                        f"the server sends a response of {length} bytes by the pipe, expected: up "
                        f"to {self._response_bytes_max}"
                    )
                end = _LENGTH.size + length
                if len(received) >= end:
                    self._received = received[end:]
                    return received[_LENGTH.size : end]
            try:
                more = self._responses.read(_RECEIVE_BYTES)
            except (OSError, ValueError):
                return None
            if not more:
                return None
            self._received = received + more

    def abandon(self) -> None:
        """In a forked child: leaves the pipes to the parent."""
        self._requests.close()
        self._responses.close()

    def hang_up(self) -> None:
        """Sends nothing more: the stream ends when what was sent is answered."""
        self._requests.close()
