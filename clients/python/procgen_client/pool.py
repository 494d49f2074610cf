"""A pool of environments on a server, and the stream that steps it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from procgen_client._proto import pools_pb2, step_pb2
from procgen_client._requests import (
    Reset,
    in_range,
    observation,
    reset_messages,
    step_exceptions,
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

# What a response for one environment has besides an observation and a final one, at most. In bytes.
_ROW_OVERHEAD_BYTES = 1024
# Where server and learner share all cores of a machine, chunks that are smaller than this,
# in bytes of observations, cost more than they save; and more of them than this save nothing.
_CHUNK_BYTES_MIN = 2 * 1024 * 1024
_DEFAULT_CHUNK_COUNT_MAX = 4


class Pool(PoolResource):
    """A number of environments that are stepped as one batch.

    Made by :meth:`Client.create_pool` or :meth:`Client.get_pool`. As a context manager it is closed
    on leaving, which deletes a pool that create_pool made; a pool from get_pool is only let go.

    The simple way is :meth:`step`. To keep both sides busy, send ahead: :meth:`send_step` and
    :meth:`receive` are the two halves of step, and up to :attr:`requests_in_flight_max` requests
    may be unanswered. Answers come in the order of the requests.

    The first request attaches to the pool: no other client can step it until :meth:`detach` or
    :meth:`close`. Where the connection breaks, the pool attaches again by itself and sends again
    what is unanswered: nothing is seen of it but a pause, unless that takes longer than the
    client's ``reconnect_timeout``. After an error of the server the stream is over, answers that
    were still owed are lost, and the next request attaches anew; the environments stand as they did
    before the request at fault.

    A step of the whole pool may be carried out in several chunks: while one is on its way, the next
    is stepped. It is one request all the same, taken whole or not at all, and its answer is one
    batch, the same whatever the number of chunks.

    An interruption (Ctrl-C) while an answer is waited for ends the stream, too, but what was sent
    is carried out.

    Threads: one at a time.

    Attributes, beside those of PoolResource:
        requests_in_flight_max: How many requests may be unanswered.
        chunk_count: In how many chunks a step of the whole pool with pictures is carried out.
        held_batches_max: With transport "shared_memory": how many batches arrays may refer to,
            besides those of unanswered requests. 0: 2.
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
    ) -> None:
        """For :class:`Client`; use its create_pool or get_pool."""
        super().__init__(client, message)
        self.requests_in_flight_max = requests_in_flight_max
        self.chunk_count = self._default_chunk_count() if chunk_count is None else chunk_count
        self.held_batches_max = held_batches_max
        self._deletes_on_close = deletes_on_close
        self._closed = False
        self._stream: _native.Stream | None = None
        self._held_batches: _native.HeldBatches | None = None  # Of the last stream.

    def __repr__(self) -> str:
        """Gives e.g. ``<Pool pools/7: 64 x coinrun>``."""
        return f"<Pool {self.name}: {self.env_count} x {','.join(self.spec.games)}>"

    def __enter__(self) -> Pool:
        """Gives the pool itself."""
        return self

    def __exit__(self, *exception: object) -> None:
        """Closes the pool."""
        self.close()

    @property
    def attached(self) -> bool:
        """Whether this object holds the pool's stream."""
        return self._stream is not None

    @property
    def in_flight(self) -> int:
        """Number of requests whose answers were not received yet."""
        if self._stream is None or self._client._is_abandoned:
            return 0
        return self._stream.in_flight

    # Stepping: the simple way. One request, one answer.

    def step(
        self,
        actions: npt.ArrayLike,
        *,
        first_env: int = 0,
        observe: bool = True,
        repeat_count: int = 1,
        final_observations: bool = False,
        next_levels: Mapping[int, int] | None = None,
        resets: Iterable[int | Reset] = (),
    ) -> Batch:
        """Steps each environment of a slice, and waits for the answer.

        Args:
            actions: int [n], each in [-1, 15): what the environments first_env ...
                first_env + n - 1 do; -1 does nothing and ends the episode. n is env_count,
                unless a part of the pool is stepped.
            first_env: Index of the slice's first environment.
            observe: False: no pictures are drawn or sent, which is many times faster.
            repeat_count: The same action is taken so many times, in [1, 1000]; rewards are summed,
                and an environment stops when its episode ends.
            final_observations: Where an episode ends, its last picture is answered, too. Only of
                use with autoreset_mode "same_step".
            next_levels: Level seeds by environment (index in the pool), to be played after the
                present levels.
            resets: Environments (indices in the pool, or Resets) that begin a new episode in place
                of being stepped; their actions are ignored.

        Raises:
            InvalidArgumentError: An argument has a wrong length or is out of range. Nothing has
                moved.
            FailedPreconditionError: Answers of requests sent before were not received; another
                client is attached; or an ended episode is stepped (autoreset_mode "disabled").
            ProcgenError: Whatever else the server says.
        """
        self._require_nothing_in_flight()
        self.send_step(
            actions,
            first_env=first_env,
            observe=observe,
            repeat_count=repeat_count,
            final_observations=final_observations,
            next_levels=next_levels,
            resets=resets,
        )
        return self.receive()

    def observe(
        self,
        *,
        first_env: int = 0,
        env_count: int | None = None,
        observe: bool = True,
    ) -> Batch:
        """Returns the current state of a slice (default: the whole pool) without stepping.

        This is how a learner gets the first observations. Rewards and ends are those of the last
        step again, not to be added up. Errors as :meth:`step`.
        """
        self._require_nothing_in_flight()
        self.send_observe(
            first_env=first_env,
            env_count=env_count,
            observe=observe,
        )
        return self.receive()

    def reset(
        self,
        resets: Iterable[int | Reset] | None = None,
        *,
        first_env: int = 0,
        env_count: int | None = None,
        observe: bool = True,
    ) -> Batch:
        """Starts new episodes in some environments of a slice and returns the slice's state.

        Args:
            resets: Environments (indices in the pool, or Resets), at least one, each at most once.
                None: all of the slice. The others are left as they are.
            first_env: Index of the slice's first environment.
            env_count: Number of environments of the slice. None: all from the first to the
                pool's last.
            observe: False: no pictures.

        Errors as :meth:`step`.
        """
        self._require_nothing_in_flight()
        self.send_reset(
            resets,
            first_env=first_env,
            env_count=env_count,
            observe=observe,
        )
        return self.receive()

    def set_level_sampler(self, level_sampler: LevelSampler) -> None:
        """Replaces what chooses the levels; takes effect at each environment's next episode.

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
        observe: bool = True,
        repeat_count: int = 1,
        final_observations: bool = False,
        next_levels: Mapping[int, int] | None = None,
        resets: Iterable[int | Reset] = (),
    ) -> int:
        """Sends the request of :meth:`step`, and gives its sequence number.

        :meth:`receive` gives the answer.

        Raises:
            InvalidArgumentError: As step.
            FailedPreconditionError: requests_in_flight_max requests are unanswered: receive first.
                Or arrays refer to so many batches of shared memory that there is none for the
                answer: let go of some, or copy them. Nothing was sent.
        """
        array = np.asarray(actions)
        is_whole = array.size == self.env_count
        if first_env or not is_whole:
            self._check_slice(first_env, array.size, "actions")
        return self._ready_stream().send_step(
            array,
            first_env,
            repeat_count if repeat_count == 1 else in_range("repeat_count", repeat_count, 1, 1000),
            bool(observe),
            bool(final_observations),
            self.chunk_count if observe and is_whole else 0,
            step_exceptions(next_levels, resets) if next_levels or resets != () else b"",
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

    def receive(self) -> Batch:
        """Waits for the answer to the oldest unanswered request.

        Raises:
            FailedPreconditionError: No request is unanswered.
            ProcgenError: The server refused that request, or is gone. The stream is over, and
                answers to later requests are lost with it.
        """
        self._client.check_open()
        stream = self._stream
        if stream is None or not stream.in_flight:
            raise FailedPreconditionError(f"no request to {self.name} is unanswered: send first")
        try:
            return batch_of(stream.receive())
        except BaseException:
            self._drop()
            raise

    # The stream's beginning and end.

    def attach(self, *, take_over: bool = False, response_bytes_max: int = 0) -> None:
        """Takes the pool for this object. Never necessary: the first request does so.

        Args:
            take_over: End another client's stream, if there is one.
            response_bytes_max: Largest response that the server may send, in bytes; larger answers
                come in several, which receive joins, and part of which are stepped while others are
                on their way. 0: 4 MiB, or what the answer for one environment takes, if that is
                more.

        Raises:
            FailedPreconditionError: Another stream is attached; or the pool shares memory and this
                is not the server's machine, or not its user.
            NotFoundError: The pool is gone.
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
        self._stream = self._client._connection.attach(
            attach.SerializeToString(), self._client.reconnect_timeout, self._held_batches
        )
        self._held_batches = self._stream.held_batches
        self.requests_in_flight_max = self._stream.requests_in_flight_max

    def detach(self) -> None:
        """Lets the pool go, so that another client can attach.

        Requests in flight are carried out; their answers are lost.
        """
        stream, self._stream = self._stream, None
        if stream is not None and not self._client._is_abandoned:
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
                pass  # It is gone, or the server is.

    # Internals.

    def _default_chunk_count(self) -> int:
        if self.spec.transport == pools_pb2.TRANSPORT_SHARED_MEMORY:
            return 1  # Nothing is on its way there.
        pool_bytes = self.env_count * int(np.prod(self.observation_shape))
        return min(max(pool_bytes // _CHUNK_BYTES_MIN, 1), _DEFAULT_CHUNK_COUNT_MAX)

    def _response_bytes_max(self) -> int:
        """Gives 0, for what servers send by default, or more where that has no room for a row."""
        if self.spec.transport == pools_pb2.TRANSPORT_SHARED_MEMORY:
            return 0  # Responses bear no values.
        observation_bytes = int(np.prod(self.observation_shape))
        # An encoded one may take half as much again; a final one is never encoded.
        is_raw = self.spec.encoding == pools_pb2.ENCODING_RAW
        sent_bytes = observation_bytes if is_raw else observation_bytes * 3 // 2
        row = sent_bytes + observation_bytes + _ROW_OVERHEAD_BYTES
        if row <= RESPONSE_BYTES_DEFAULT:
            return 0
        return min(row, self._client.catalog().limits.response_bytes_max)

    def _send(self, request: step_pb2.StepPoolRequest) -> int:
        return self._ready_stream().send(request.SerializeToString())

    def _ready_stream(self) -> _native.Stream:
        """Gives the stream, attached and with room for a request."""
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
        """Ends the stream at once; what was sent is carried out."""
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.cancel()

    def _require_nothing_in_flight(self) -> None:
        if self.in_flight:
            raise FailedPreconditionError(
                f"{self.in_flight} requests to {self.name} are unanswered: receive them first"
            )

    def _slice(self, first_env: int, env_count: int | None) -> step_pb2.Slice:
        if env_count is None:
            env_count = self.env_count - first_env
        self._check_slice(first_env, env_count, "environments")
        return step_pb2.Slice(first_env=first_env, env_count=env_count)

    def _check_slice(self, first_env: int, count: int, what: str) -> None:
        if first_env < 0 or first_env >= self.env_count:
            raise InvalidArgumentError(
                f"first_env is {first_env}; {self.name} has environments 0 ... "
                f"{self.env_count - 1}"
            )
        if count < 1 or first_env + count > self.env_count:
            raise InvalidArgumentError(
                f"{count} {what} from environment {first_env}; {self.name} has "
                f"{self.env_count} environments"
            )
