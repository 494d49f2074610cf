"""A call of gRPC on a channel of grpcio."""

from __future__ import annotations

import queue
from collections.abc import Callable, Sequence
from typing import Any


class ChannelCall:
    """A bidirectional call, of messages as bytes.

    Threads: one at a time; cancel from any.
    """

    def __init__(
        self,
        method: Callable[..., Any],
        metadata: Sequence[tuple[str, str]],
        *,
        waits_for_server: bool,
    ) -> None:
        """Begins the call.

        Args:
            method: grpcio's, without serialisers.
            metadata: What the call bears.
            waits_for_server: Whether it goes on where the server cannot be reached yet.
        """
        self._requests: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self._call = method(
            iter(self._requests.get, None), metadata=metadata, wait_for_ready=waits_for_server
        )

    def __del__(self) -> None:
        """Ends grpcio's thread that sends requests."""
        self._requests.put(None)

    def send(self, message: bytes) -> None:
        """Sends a message; that the call is over, only receive tells."""
        self._requests.put(message)

    def end_requests(self) -> None:
        """Tells the server that no more messages come."""
        self._requests.put(None)

    def receive(self) -> bytes | None:
        """Waits for the next message. None: the call has ended with OK.

        Raises:
            grpc.RpcError: It has ended otherwise.
        """
        return next(self._call, None)

    def cancel(self) -> None:
        """Ends the call at once."""
        self._requests.put(None)
        self._call.cancel()
