"""A stream's messages past gRPC: the learner's side of procgen.v1.DirectLine."""

from __future__ import annotations

import select
import socket
import struct

from procgen_client._proto import step_pb2

_LENGTH = struct.Struct("=I")
# Answers of shared memory have some tens of bytes.
_RECEIVE_BYTES = 1 << 12


class DirectLine:
    """A unix socket that bears the messages of a stream whose pool shares memory.

    Threads: one may send while another receives.
    """

    @classmethod
    def open(cls, offer: step_pb2.DirectLine) -> DirectLine | None:
        """Connects; None: that cannot be done from here, and gRPC's stream does as well."""
        line = socket.socket(socket.AF_UNIX)
        try:
            line.connect("\0" + offer.socket_name)
            line.sendall(offer.key)
        except OSError:
            line.close()
            return None
        return cls(line)

    def __init__(self, line: socket.socket) -> None:
        """Takes over a socket that has shown its key."""
        self._line = line
        self._arrives = select.poll()
        self._arrives.register(line, select.POLLIN)
        self._received = b""

    def send(self, message: bytes) -> None:
        """Sends a serialised request; that the line has ended, only receive finds."""
        try:
            self._line.sendall(_LENGTH.pack(len(message)) + message)
        except OSError:
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
                self._arrives.poll()
                more = self._line.recv(_RECEIVE_BYTES)
            except OSError:
                return None
            if not more:
                return None
            self._received = received + more

    def hang_up(self) -> None:
        """Ends the line for both sides."""
        self._line.close()
