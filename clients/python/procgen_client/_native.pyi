"""The C++ client (clients/python/native). Private. Messages are serialised bytes.

Without this module, `_transport.grpc_fallback` provides the same classes.
"""

from collections.abc import Sequence

import numpy as np

class Batch:
    """An answer of a stream."""

    @property
    def sequence_number(self) -> int: ...
    @property
    def first_env(self) -> int: ...
    def array(self, name: str) -> np.ndarray | None:
        """Makes the array with this name; None: observations that were not requested."""

class HeldBatches:
    """The batches of shared memory that a learner's arrays refer to."""

class Stream:
    """The stream of an attached learner. Raises the errors of `procgen_client.errors`."""

    @property
    def requests_in_flight_max(self) -> int: ...
    @property
    def in_flight(self) -> int: ...
    @property
    def held_batches(self) -> HeldBatches | None: ...
    def send(self, request: bytes) -> int:
        """Sends a StepPoolRequest; returns its sequence number."""
    def send_step(
        self,
        actions: np.ndarray,
        first_env: int,
        repeat_count: int,
        observe: bool,
        final_observations: bool,
        chunk_count: int,
        more: bytes,
    ) -> int:
        """Sends a step; `more` is empty, or a serialised Step with next levels and resets."""
    def receive(self) -> Batch:
        """Waits for the answer to the oldest unanswered request."""
    def begin_receive(self) -> int:
        """Returns an eventfd, readable when the answer has arrived. Not in the fallback."""
    def end_receive(self) -> Batch:
        """Returns the answer. The eventfd must be readable."""
    def close(self) -> None:
        """Ends the stream and waits for the server to end it."""
    def cancel(self) -> None:
        """Ends the stream at once; from any thread."""

class Watch:
    """A server stream conflated to the latest message."""

    def __iter__(self) -> Watch: ...
    def __next__(self) -> bytes: ...
    def close(self) -> None: ...

class Connection:
    """A connection to a server."""

    def __init__(
        self,
        address: str,
        *,
        timeout: float | None,
        call_timeout: float,
        ca: bytes,
        certificate: bytes,
        key: bytes,
        token: str,
        token_in_plain_text: bool,
        channel_options: Sequence[tuple[str, int | str]],
    ) -> None: ...
    def call(self, method: str, request: bytes) -> bytes:
        """Calls a unary method, e.g. "CreatePool". Lists and states are joined to one message."""
    def watch(self, method: str, request: bytes) -> Watch:
        """Calls "WatchNodes" or "WatchPool"."""
    def attach(
        self, attach: bytes, reconnect_timeout: float, held_batches: HeldBatches | None
    ) -> Stream:
        """Attaches; `held_batches`: those of the learner's previous stream."""
    def close(self) -> None:
        """Ends all calls with CancelledError."""
