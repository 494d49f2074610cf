"""A stream's messages past gRPC: the learner's side of procgen.v1.DirectLine."""

from __future__ import annotations

import os
import socket
import struct
from typing import BinaryIO

from procgen_client import _fork
from procgen_client._proto import step_pb2

_LENGTH = struct.Struct("=I")
# Answers of shared memory have some tens of bytes.
_RECEIVE_BYTES = 1 << 12


class DirectLine:
    """Two pipes that bear the messages of a stream whose pool shares memory.

    Threads: one may send while another receives.
    """

    @classmethod
    def open(cls, offer: step_pb2.DirectLine) -> DirectLine | None:
        """Connects; None: that cannot be done from here, and gRPC's stream does as well."""
        with socket.socket(socket.AF_UNIX) as connection:
            try:
                connection.connect("\0" + offer.socket_name)
                connection.sendall(offer.key)
                _, ends, _, _ = socket.recv_fds(connection, 1, 2)
                for end in ends:
                    os.set_inheritable(end, False)
                requests, responses = ends
            except (OSError, ValueError):  # There is nobody, or nobody who knows the key.
                return None
        return cls(os.fdopen(requests, "wb", buffering=0), os.fdopen(responses, "rb", buffering=0))

    def __init__(self, requests: BinaryIO, responses: BinaryIO) -> None:
        """Takes over the learner's ends of the pipes."""
        self._requests = requests
        self._responses = responses
        self._received = b""
        _fork.bind(self)

    def send(self, message: bytes) -> None:
        """Sends a serialised request; that the line has ended, only receive finds."""
        left = _LENGTH.pack(len(message)) + message
        try:
            while left:
                left = left[self._requests.write(left) :]
        except (OSError, ValueError):  # It has ended, or this side has hung up.
            pass

    def receive(self) -> bytes | None:
        """Waits for the next serialised response. None: the line has ended."""
        while True:
            received = self._received
            if len(received) >= _LENGTH.size:
                end = _LENGTH.size + _LENGTH.unpack_from(received)[0]
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
