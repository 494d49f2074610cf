"""The client for asyncio: pools that are stepped while other coroutines run.

    async with await connect("localhost:50051") as client:
        async with await client.create_pool("coinrun", 64) as pool:
            batch = await pool.step([7] * 64)

Batches, options, errors and reconnection are those of :class:`procgen_client.Client`.
"""

from __future__ import annotations

import asyncio
import functools
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, TypeVar

import numpy.typing as npt

from procgen_client._out import copied_into
from procgen_client._proto import catalog_pb2, pools_pb2
from procgen_client._requests import Reset
from procgen_client.batch import Batch
from procgen_client.client import Client
from procgen_client.credentials import Credentials
from procgen_client.errors import FailedPreconditionError
from procgen_client.pool import Pool

if TYPE_CHECKING:
    from procgen_client import _native

_Result = TypeVar("_Result")

# Threads of a client for calls other than steps: the maximum number of concurrent calls.
_CALL_THREADS = 4


async def _answer_of(stream: _native.Stream) -> _native.Batch:
    """Waits for a stream's answer: on an eventfd, with grpcio in a thread."""
    loop = asyncio.get_running_loop()
    if not hasattr(stream, "begin_receive"):
        return await loop.run_in_executor(None, stream.receive)
    file = stream.begin_receive()
    is_there = asyncio.Event()
    loop.add_reader(file, is_there.set)
    try:
        await is_there.wait()
    finally:
        loop.remove_reader(file)
    return stream.end_receive()


async def connect(
    address: str,
    *,
    timeout: float | None = None,
    reconnect_timeout: float = 60.0,
    credentials: Credentials | None = None,
) -> AsyncClient:
    """Connects to a server.

    Args:
        address, timeout, reconnect_timeout, credentials: As for procgen_client.Client.

    Errors as procgen_client.Client.
    """
    connect_client = functools.partial(
        Client,
        address,
        timeout=timeout,
        reconnect_timeout=reconnect_timeout,
        credentials=credentials,
    )
    loop = asyncio.get_running_loop()
    return AsyncClient(await loop.run_in_executor(None, connect_client))


class AsyncClient:
    """A connection to a server; made by :func:`connect`. An asynchronous context manager.

    Tasks: any number of one event loop; a pool belongs to one task at a time.

    Attributes:
        address: Address of the server.
        reconnect_timeout: Time for which pools try to resume a broken connection, in seconds.
    """

    def __init__(self, client: Client) -> None:
        """For :func:`connect`."""
        self.address = client.address
        self.reconnect_timeout = client.reconnect_timeout
        self._client = client
        self._threads = ThreadPoolExecutor(_CALL_THREADS, "procgen-calls")

    async def __aenter__(self) -> AsyncClient:
        """Returns the client itself."""
        return self

    async def __aexit__(self, *exception: object) -> None:
        """Closes the connection."""
        await self.close()

    async def close(self) -> None:
        """Closes the connection; running calls end with CancelledError."""
        self._client.close()
        self._threads.shutdown(wait=False)

    def catalog(self) -> catalog_pb2.Catalog:
        """Returns the server's catalog, as procgen_client.Client.catalog."""
        return self._client.catalog()

    async def create_pool(
        self, games: str | Sequence[str], env_count: int = 64, **arguments: Any
    ) -> AsyncPool:
        """Creates a pool; arguments and errors as procgen_client.Client.create_pool."""
        make = functools.partial(self._client.create_pool, games, env_count, **arguments)
        return AsyncPool(self, await self._run(make))

    async def get_pool(self, name: str, **arguments: Any) -> AsyncPool:
        """Returns an existing pool; closing it does not delete it.

        Arguments and errors as procgen_client.Client.get_pool.
        """
        return AsyncPool(
            self, await self._run(functools.partial(self._client.get_pool, name, **arguments))
        )

    async def list_pools(self) -> list[pools_pb2.Pool]:
        """Returns the pools, oldest first."""
        return await self._run(self._client.list_pools)

    async def _run(self, call: Callable[[], _Result]) -> _Result:
        """Runs a blocking call on a thread and waits for it."""
        self._client.check_open()
        return await asyncio.get_running_loop().run_in_executor(self._threads, call)


class AsyncPool:
    """N environments that are stepped together, as procgen_client.Pool.

    An asynchronous context manager: leaving it deletes a pool that create_pool made.

    Tasks: one at a time. Cancelling a task that waits ends the stream. The server executes the
    requests that were sent, and the next request attaches again.

    Attributes:
        name, spec, env_count, observation_shape, transport, transport_reason: As Pool's.
    """

    def __init__(self, client: AsyncClient, pool: Pool) -> None:
        """For :class:`AsyncClient`; use its create_pool or get_pool."""
        self.name = pool.name
        self.spec = pool.spec
        self.env_count = pool.env_count
        self.observation_shape = pool.observation_shape
        self.transport = pool.transport
        self.transport_reason = pool.transport_reason
        self._client = client
        self._pool = pool
        self._was_given_up = False  # The last stream was cancelled; the server may still have it.

    async def __aenter__(self) -> AsyncPool:
        """Returns the pool itself."""
        return self

    async def __aexit__(self, *exception: object) -> None:
        """Closes the pool."""
        await self.close()

    @property
    def requests_in_flight_max(self) -> int:
        """Number of requests that may be unanswered."""
        return self._pool.requests_in_flight_max

    @property
    def in_flight(self) -> int:
        """Number of requests whose answers were not received."""
        return self._pool.in_flight

    async def step(
        self,
        actions: npt.ArrayLike,
        *,
        first_env: int = 0,
        env_count: int | None = None,
        observe: bool = True,
        out: Any = None,  # noqa: ANN401 - an array or tensor
        **arguments: Any,
    ) -> Batch:
        """Steps environments, and waits for the answer; arguments and errors as Pool.step."""
        row_count = self._pool._row_count(first_env, env_count)
        self._check_request(out, row_count, observe)
        await self.send_step(
            actions, first_env=first_env, env_count=env_count, observe=observe, **arguments
        )
        return await self.receive(out=out)

    async def observe(self, *, observe: bool = True, out: Any = None) -> Batch:  # noqa: ANN401
        """Returns the pool's current state without stepping; rewards repeat the last step's."""
        self._check_request(out, self.env_count, observe)
        await self.attach()
        self._pool.send_observe(observe=observe)
        return await self.receive(out=out)

    async def reset(
        self,
        resets: Iterable[int | Reset] | None = None,
        *,
        out: Any = None,  # noqa: ANN401 - an array or tensor
    ) -> Batch:
        """Starts new episodes in some environments (None: all) and returns the pool's state."""
        self._check_request(out, self.env_count, True)
        await self.attach()
        self._pool.send_reset(resets)
        return await self.receive(out=out)

    async def send_step(self, actions: npt.ArrayLike, **arguments: Any) -> None:
        """Sends the request of :meth:`step`, for receive. Errors as Pool.send_step."""
        await self.attach()
        self._pool.send_step(actions, **arguments)

    async def receive(self, *, out: Any = None) -> Batch:  # noqa: ANN401 - an array or tensor
        """Waits for the answer to the oldest unanswered request; errors as Pool.receive."""
        stream = self._pool._stream
        if stream is None or not stream.in_flight:
            raise FailedPreconditionError(f"no request to {self.name} is unanswered: send first")
        self._client._client.check_open()
        view = self._pool._view_of(out)
        try:
            batch = self._pool._batch_of(await _answer_of(stream), is_copied=view is not None)
        except BaseException:
            self._drop()
            raise
        return copied_into(batch, out, view)

    async def attach(self, *, take_over: bool = False, response_bytes_max: int = 0) -> None:
        """Opens the pool's stream. Optional: the first request does it.

        Arguments and errors as Pool.attach.
        """
        if self._pool.attached:
            return
        attach = functools.partial(
            self._pool.attach,
            take_over=take_over or self._was_given_up,
            response_bytes_max=response_bytes_max,
        )
        await self._client._run(attach)
        self._was_given_up = False

    async def save_states(self, environments: Sequence[int] | None = None) -> list[bytes]:
        """Returns snapshots of environments; arguments and errors as Pool.save_states."""
        return await self._client._run(lambda: self._pool.save_states(environments))

    async def restore_states(self, states: Mapping[int, bytes] | Sequence[bytes]) -> None:
        """Restores environments from snapshots; arguments and errors as Pool.restore_states."""
        await self._client._run(lambda: self._pool.restore_states(states))

    async def clone_states(self, pairs: Iterable[tuple[int, int]]) -> None:
        """Copies states between environments of the pool; errors as Pool.clone_states."""
        await self._client._run(lambda: self._pool.clone_states(pairs))

    async def close(self) -> None:
        """Deletes the pool if create_pool made it; the answers of requests in flight are lost."""
        self._drop()
        if not self._client._client.closed:
            await self._client._run(self._pool.close)

    def _check_request(self, out: object, row_count: int, observe: bool) -> None:
        self._pool._require_nothing_in_flight()
        if out is not None:
            self._pool._check_out(out, row_count, observe)

    def _drop(self) -> None:
        if self._pool.attached:
            self._pool._drop()
            self._was_given_up = True
