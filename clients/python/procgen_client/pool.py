"""A pool of environments on a server, and the stream that steps it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from procgen_client._out import copied_into, writable_view
from procgen_client._proto import pools_pb2, step_pb2
from procgen_client._requests import (
    Reset,
    in_range,
    observation,
    optional_step_fields,
    reset_messages,
)
from procgen_client.batch import Batch, batch_of
from procgen_client.errors import (
    FailedPreconditionError,
    InvalidArgumentError,
    NotFoundError,
    UnavailableError,
)
from procgen_client.options import LevelSampler, level_sampler_message
from procgen_client.pool_resource import RESPONSE_BYTES_DEFAULT, PoolResource

if TYPE_CHECKING:
    from procgen_client import _native
    from procgen_client.client import Client

# Upper bound of a response for one environment without its two observations, in bytes.
_ROW_OVERHEAD_BYTES = 1024
# Observation bytes of a chunk. Smaller chunks cost more than they save where server and learner
# share all cores, and more than _DEFAULT_CHUNK_COUNT_MAX chunks save nothing.
_CHUNK_BYTES_MIN = 2 * 1024 * 1024
_DEFAULT_CHUNK_COUNT_MAX = 4


class Pool(PoolResource):
    """N environments that are stepped together.

    Made by :meth:`Client.create_pool` or :meth:`Client.get_pool`. A context manager: leaving it
    deletes a pool that create_pool made, and detaches from a pool that get_pool returned.

    :meth:`step` sends a request and waits for its answer. To keep server and learner busy, send
    ahead with :meth:`send_step` and :meth:`receive`: up to :attr:`requests_in_flight_max` requests
    may be unanswered. Answers arrive in the order of the requests.

    The first request attaches to the pool. No other client can step it until :meth:`detach` or
    :meth:`close`. After a broken connection the pool attaches again and resends the unanswered
    requests: the learner sees a pause. After the client's ``reconnect_timeout`` it gives up. An
    error of the server ends the stream, and unreceived answers are lost. The environments are as
    before the rejected request, and the next request attaches again.

    The server may step the whole pool in several chunks: it steps one while another is sent. It is
    still one request, which is executed as a whole or not at all, and the batch is the same for any
    number of chunks.

    Ctrl-C during a wait also ends the stream; the server executes the requests that were sent.

    Threads: one at a time.

    Attributes, in addition to those of PoolResource:
        requests_in_flight_max: Number of requests that may be unanswered.
        chunk_count: Number of chunks of a whole-pool step with observations.
        transport_reason: Why the pool has its transport.
        held_batches_max: With transport "shared_memory" and `copy` False: number of batches that
            arrays may refer to, in addition to those of unanswered requests. 0: 2.
    """

    def __init__(
        self,
        client: Client,
        message: pools_pb2.Pool,
        *,
        deletes_on_close: bool,
        requests_in_flight_max: int = 2,
        chunk_count: int | None = None,
        held_batches_max: int = 0,
        copy: bool = True,
    ) -> None:
        """For :class:`Client`; use its create_pool or get_pool."""
        super().__init__(client, message)
        self.requests_in_flight_max = requests_in_flight_max
        self.chunk_count = self._default_chunk_count() if chunk_count is None else chunk_count
        self.held_batches_max = held_batches_max
        self.transport_reason = "the pool was created with it"
        self._owns_arrays = copy and self.transport == "shared_memory"
        self._deletes_on_close = deletes_on_close
        self._closed = False
        self._has_attached = False
        self._stream: _native.Stream | None = None
        self._held_batches: _native.HeldBatches | None = None  # Of the last stream.

    def __repr__(self) -> str:
        """Returns e.g. ``<Pool pools/7: 64 x coinrun>``."""
        return f"<Pool {self.name}: {self.env_count} x {','.join(self.spec.games)}>"

    def __enter__(self) -> Pool:
        """Returns the pool itself."""
        return self

    def __exit__(self, *exception: object) -> None:
        """Closes the pool."""
        self.close()

    @property
    def transport(self) -> str:
        """Way of the batches to the learner: "shared_memory" or "stream"."""
        is_shared = self.spec.transport == pools_pb2.TRANSPORT_SHARED_MEMORY
        return "shared_memory" if is_shared else "stream"

    @property
    def attached(self) -> bool:
        """Whether this object has the pool's stream."""
        return self._stream is not None

    @property
    def in_flight(self) -> int:
        """Number of requests whose answers were not received."""
        if self._stream is None or self._client._is_abandoned:
            return 0
        return self._stream.in_flight

    # Stepping: one request and its answer.

    def step(
        self,
        actions: npt.ArrayLike,
        *,
        first_env: int = 0,
        env_count: int | None = None,
        observe: bool = True,
        repeat_count: int = 1,
        final_observations: bool = False,
        next_levels: Mapping[int, int] | None = None,
        resets: Iterable[int | Reset] = (),
        annotations: Mapping[str, npt.ArrayLike] | None = None,
        out: Any = None,  # noqa: ANN401 - an array or tensor
    ) -> Batch:
        """Steps each environment of a slice (default: the whole pool), and waits for the answer.

        Args:
            actions: int [n], each in [-1, 15), one for each of the slice's n environments. -1 ends
                the episode without a move.
            first_env: Index of the slice's first environment.
            env_count: Number of environments of the slice, n. None: all from first_env to the end
                of the pool.
            observe: False: observations are neither rendered nor sent, which is many times faster.
            repeat_count: Number of times that the action is repeated, in [1, 1000]. Rewards are
                summed, and an environment stops when its episode ends.
            final_observations: Also return the last observation of each episode that ends. Only
                useful with autoreset_mode "same_step".
            next_levels: Level seeds by environment (index in the pool), for the next episodes.
            resets: Environments (indices in the pool, or Resets) that start a new episode instead
                of a step; their actions are ignored.
            annotations: Values by name, [n] or [n, k], shown to viewers of the pool in a
                browser: ``{"value": values, "action_probabilities": probabilities}``. At most 16
                names of 64 bytes, and 64 values for each environment.
            out: Array or tensor for the observations; see :meth:`receive`.

        Raises:
            InvalidArgumentError: An argument is out of range, or its length is wrong, such as
                fewer actions than the slice has environments. Nothing was stepped.
            FailedPreconditionError: Requests are unanswered; another client is attached; or an
                ended episode is stepped (autoreset_mode "disabled").
            ProcgenError: Any other error of the server.
        """
        self._require_nothing_in_flight()
        if out is not None:
            self._check_out(out, self._row_count(first_env, env_count), observe)
        self.send_step(
            actions,
            first_env=first_env,
            env_count=env_count,
            observe=observe,
            repeat_count=repeat_count,
            final_observations=final_observations,
            next_levels=next_levels,
            resets=resets,
            annotations=annotations,
        )
        return self.receive(out=out)

    def observe(
        self,
        *,
        first_env: int = 0,
        env_count: int | None = None,
        observe: bool = True,
        out: Any = None,  # noqa: ANN401 - an array or tensor
    ) -> Batch:
        """Returns the current state of a slice (default: the whole pool) without stepping.

        A learner gets the first observations this way. Rewards and ends repeat those of the last
        step: do not add them up. `out` and errors as :meth:`step`.
        """
        self._require_nothing_in_flight()
        if out is not None:
            self._check_out(out, self._row_count(first_env, env_count), observe)
        self.send_observe(first_env=first_env, env_count=env_count, observe=observe)
        return self.receive(out=out)

    def reset(
        self,
        resets: Iterable[int | Reset] | None = None,
        *,
        first_env: int = 0,
        env_count: int | None = None,
        observe: bool = True,
        out: Any = None,  # noqa: ANN401 - an array or tensor
    ) -> Batch:
        """Starts new episodes in some environments of a slice and returns the slice's state.

        Args:
            resets: Environments (indices in the pool, or Resets), at least one, each at most once.
                None: all of the slice. The others do not change.
            first_env: Index of the slice's first environment.
            env_count: Number of environments of the slice. None: up to the pool's last.
            observe: False: no observations.
            out: Array or tensor for the observations; see :meth:`receive`.

        Errors as :meth:`step`.
        """
        self._require_nothing_in_flight()
        if out is not None:
            self._check_out(out, self._row_count(first_env, env_count), observe)
        self.send_reset(
            resets,
            first_env=first_env,
            env_count=env_count,
            observe=observe,
        )
        return self.receive(out=out)

    def set_level_sampler(self, level_sampler: LevelSampler) -> None:
        """Replaces the level sampler; takes effect at each environment's next episode.

        Errors as :meth:`step`.
        """
        self._require_nothing_in_flight()
        sampler = level_sampler_message(level_sampler)
        self._send(step_pb2.StepPoolRequest(level_sampler=sampler))
        self.receive()

    # Stepping with requests sent ahead.

    def send_step(
        self,
        actions: npt.ArrayLike,
        *,
        first_env: int = 0,
        env_count: int | None = None,
        observe: bool = True,
        repeat_count: int = 1,
        final_observations: bool = False,
        next_levels: Mapping[int, int] | None = None,
        resets: Iterable[int | Reset] = (),
        annotations: Mapping[str, npt.ArrayLike] | None = None,
    ) -> int:
        """Sends the request of :meth:`step`, and returns its sequence number.

        :meth:`receive` returns the answer.

        Raises:
            InvalidArgumentError: As step.
            FailedPreconditionError: requests_in_flight_max requests are unanswered: receive first.
                Or arrays refer to too many batches of shared memory: copy or delete some. Nothing
                was sent.
        """
        array = np.asarray(actions)
        env_count = self._row_count(first_env, env_count)
        if array.size != env_count:
            raise InvalidArgumentError(
                f"actions has {array.size} entries; {self.name} has {env_count} environments from "
                f"{first_env} on (first_env and env_count choose a slice)"
            )
        more = b""
        if next_levels or resets != () or annotations:
            more = optional_step_fields(next_levels, resets, annotations, array.size)
        return self._ready_stream().send_step(
            array,
            first_env,
            repeat_count if repeat_count == 1 else in_range("repeat_count", repeat_count, 1, 1000),
            bool(observe),
            bool(final_observations),
            self.chunk_count if observe and env_count == self.env_count else 0,
            more,
        )

    def send_observe(
        self,
        *,
        first_env: int = 0,
        env_count: int | None = None,
        observe: bool = True,
    ) -> int:
        """Sends the request of :meth:`observe`; errors as :meth:`send_step`."""
        which = self._slice(first_env, env_count)
        request = step_pb2.Observe(slice=which, observation=observation(observe))
        return self._send(step_pb2.StepPoolRequest(observe=request))

    def send_reset(
        self,
        resets: Iterable[int | Reset] | None = None,
        *,
        first_env: int = 0,
        env_count: int | None = None,
        observe: bool = True,
    ) -> int:
        """Sends the request of :meth:`reset`; errors as :meth:`send_step`."""
        which = self._slice(first_env, env_count)
        if resets is None:
            resets = range(first_env, first_env + which.env_count)
        request = step_pb2.ResetSlice(
            slice=which, resets=reset_messages(resets), observation=observation(observe)
        )
        return self._send(step_pb2.StepPoolRequest(reset=request))

    def receive(self, *, out: Any = None) -> Batch:  # noqa: ANN401 - an array or tensor
        """Waits for the answer to the oldest unanswered request.

        Args:
            out: Array or tensor into which the observations are copied, and which becomes
                Batch.observations: writable, C-contiguous, uint8 [n, *F]. A numpy array, a torch
                tensor on the CPU (also in pinned memory), or a buffer. None: a view of the memory
                that the answer is received into.

        Raises:
            InvalidArgumentError: `out` is of another kind; nothing was received. Or its number of
                rows is not that of the answer, which is lost.
            FailedPreconditionError: No request is unanswered.
            ProcgenError: The server rejected the request or is unreachable. The stream has ended,
                and the answers to later requests are lost.
        """
        self._client.check_open()
        stream = self._stream
        if stream is None or not stream.in_flight:
            raise FailedPreconditionError(f"no request to {self.name} is unanswered: send first")
        view = self._view_of(out)
        try:
            batch = self._batch_of(stream.receive(), is_copied=view is not None)
        except BaseException as error:
            if isinstance(error, NotFoundError | UnavailableError):
                self._deletes_on_close = False  # By then its name may be another pool's.
            self._drop()
            raise
        return copied_into(batch, out, view)

    # Start and end of the stream.

    def attach(self, *, take_over: bool = False, response_bytes_max: int = 0) -> None:
        """Opens the pool's stream. Optional: the first request does it.

        Args:
            take_over: End another client's stream, if there is one.
            response_bytes_max: Largest response that the server may send, in bytes. Larger answers
                are sent in several responses, which receive joins. 0: 4 MiB, or the size of the
                answer for one environment if that is larger.

        Raises:
            FailedPreconditionError: Another stream is attached; or the pool shares memory, and
                this process is on another machine than the server or runs as another user.
            NotFoundError: The pool does not exist any more.
        """
        if self._closed:
            raise FailedPreconditionError(f"{self.name} was closed by this client")
        if self._stream is not None:
            return
        attach = step_pb2.Attach(
            pool=self.name,
            requests_in_flight_max=self.requests_in_flight_max,
            take_over=take_over,
            response_bytes_max=response_bytes_max or self._response_bytes_max(),
            held_batches_max=self.held_batches_max,
        )
        self._client.check_open()
        try:
            self._stream = self._client._connection.attach(
                attach.SerializeToString(), self._client.reconnect_timeout, self._held_batches
            )
        except NotFoundError as error:
            if not self._has_attached:
                raise
            self._deletes_on_close = False
            raise NotFoundError(
                f"{error.message}: the server was restarted since this pool was attached, or the "
                "pool's lease ran out; create a pool and restore the states of a checkpoint"
            ) from None
        self._has_attached = True
        self._held_batches = self._stream.held_batches
        self.requests_in_flight_max = self._stream.requests_in_flight_max

    def detach(self) -> None:
        """Ends the stream, so that another client can attach.

        The server executes the requests in flight; their answers are lost.
        """
        stream, self._stream = self._stream, None
        if stream is not None and not self._client.closed and not self._client._is_abandoned:
            stream.close()

    def close(self) -> None:
        """Detaches, and deletes the pool if create_pool made it. Closing again does nothing."""
        if self._closed:
            return
        self.detach()
        self._closed = True
        if self._deletes_on_close and not self._client.closed:
            try:
                self._client.delete_pool(self.name)
            except (NotFoundError, UnavailableError):
                pass  # The pool or the server does not exist any more.

    # Internals.

    def _default_chunk_count(self) -> int:
        if self.transport == "shared_memory":
            return 1  # Nothing is sent.
        pool_bytes = self.env_count * int(np.prod(self.observation_shape))
        return min(max(pool_bytes // _CHUNK_BYTES_MIN, 1), _DEFAULT_CHUNK_COUNT_MAX)

    def _response_bytes_max(self) -> int:
        """Returns 0, the server's default, or more where that has no room for one environment."""
        if self.transport == "shared_memory":
            return 0  # Responses contain no values.
        observation_bytes = int(np.prod(self.observation_shape))
        # Encoding adds at most half; final observations are never encoded.
        is_raw = self.spec.encoding == pools_pb2.ENCODING_RAW
        sent_bytes = observation_bytes if is_raw else observation_bytes * 3 // 2
        row = sent_bytes + observation_bytes + _ROW_OVERHEAD_BYTES
        if row <= RESPONSE_BYTES_DEFAULT:
            return 0
        return min(row, self._client.catalog().limits.response_bytes_max)

    def _batch_of(self, received: _native.Batch, *, is_copied: bool = False) -> Batch:
        return batch_of(received, owned=self._owns_arrays and not is_copied)

    def _send(self, request: step_pb2.StepPoolRequest) -> int:
        return self._ready_stream().send(request.SerializeToString())

    def _ready_stream(self) -> _native.Stream:
        """Returns the attached stream, after checking that another request may be sent."""
        self._client.check_open()
        if self._stream is None:
            self.attach()
        stream = self._stream
        assert stream is not None
        if stream.in_flight >= self.requests_in_flight_max:
            raise FailedPreconditionError(
                f"{stream.in_flight} requests to {self.name} are unanswered, of at most "
                f"{self.requests_in_flight_max}: receive first"
            )
        return stream

    def _drop(self) -> None:
        """Ends the stream at once; the server executes the requests that were sent."""
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.cancel()

    def _require_nothing_in_flight(self) -> None:
        if self.in_flight:
            raise FailedPreconditionError(
                f"{self.in_flight} requests to {self.name} are unanswered: receive them first"
            )

    def _view_of(self, out: object) -> np.ndarray | None:
        """Returns a view of `out`, with room for any number of rows."""
        return None if out is None else writable_view(out, (None, *self.observation_shape))

    def _check_out(self, out: object, row_count: int, observe: bool) -> None:
        """Raises InvalidArgumentError unless `out` has room for the rows of an answer."""
        if not observe:
            raise InvalidArgumentError("out is given, but observe is False: nothing is observed")
        writable_view(out, (row_count, *self.observation_shape))

    def _slice(self, first_env: int, env_count: int | None) -> step_pb2.Slice:
        row_count = self._row_count(first_env, env_count)
        return step_pb2.Slice(first_env=first_env, env_count=row_count)

    def _row_count(self, first_env: int, env_count: int | None) -> int:
        """Returns the number of environments of a slice, which must be one of the pool."""
        if first_env < 0 or first_env >= self.env_count:
            raise InvalidArgumentError(
                f"first_env is {first_env}; {self.name} has environments 0 ... "
                f"{self.env_count - 1}"
            )
        if env_count is None:
            return self.env_count - first_env
        if env_count < 1 or first_env + env_count > self.env_count:
            raise InvalidArgumentError(
                f"env_count is {env_count} from environment {first_env}; {self.name} has "
                f"{self.env_count} environments"
            )
        return env_count
