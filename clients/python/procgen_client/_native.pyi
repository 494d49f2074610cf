"""The C++ client (clients/python/native). Private; messages are serialised.

Where this module is missing, `_transport.grpc_fallback` has the same classes.
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
        """Makes the array of this name; None: observations that were not asked for."""

class HeldBatches:
    """What a learner holds of the memory that a pool shares."""

class Stream:
    """A learner's hold of a pool. Errors of waits are those of `procgen_client.errors`."""

    @property
    def requests_in_flight_max(self) -> int: ...
    @property
    def in_flight(self) -> int: ...
    @property
    def held_batches(self) -> HeldBatches | None: ...
    def send(self, request: bytes) -> int:
        """Sends a StepPoolRequest; gives its sequence number."""
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
        """Sends a step; `more` is empty, or a Step with next levels and resets."""
    def receive(self) -> Batch:
        """Waits for the answer to the oldest unanswered request."""
    def begin_receive(self) -> int:
        """Gives a file that is readable when the answer is there; not of the fallback."""
    def end_receive(self) -> Batch:
        """Gives the answer, once that file is readable."""
    def close(self) -> None:
        """Ends the stream and waits until the server has."""
    def cancel(self) -> None:
        """Ends the stream at once; from any thread."""

class Watch:
    """The latest message of a call that reports changes."""

    def __iter__(self) -> Watch: ...
    def __next__(self) -> bytes: ...
    def close(self) -> None: ...

class Connection:
    """A connection to a server."""

    def __init__(
        self,
        address: str,
        *,
        timeout: float,
        call_timeout: float,
        ca: bytes,
        certificate: bytes,
        key: bytes,
        token: str,
        token_in_plain_text: bool,
        channel_options: Sequence[tuple[str, int | str]],
    ) -> None: ...
    def call(self, method: str, request: bytes) -> bytes:
        """Calls a unary method, e.g. "CreatePool". Lists and states are whole, in one message."""
    def watch(self, method: str, request: bytes) -> Watch:
        """Calls "WatchNodes" or "WatchPool"."""
    def attach(
        self, attach: bytes, reconnect_timeout: float, held_batches: HeldBatches | None
    ) -> Stream:
        """Attaches; `held_batches` is that of the stream that the learner had before."""
    def close(self) -> None:
        """Ends all calls with CancelledError."""
