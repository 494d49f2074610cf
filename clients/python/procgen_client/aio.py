"""The client for asyncio: pools that are stepped while other coroutines run.

    async with await connect("localhost:50051") as client:
        async with await client.create_pool("coinrun", 64) as pool:
            batch = await pool.step([7] * 64)

Batches, options and errors are those of :class:`procgen_client.Client`, and so is what becomes of
broken connections. Batches are received, not shared (transport "stream").
"""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import grpc
import grpc.aio
import numpy.typing as npt
from google.protobuf import message as protobuf_message

from procgen_client import _fork
from procgen_client import options as _options
from procgen_client._proto import (
    catalog_pb2,
    catalog_pb2_grpc,
    pools_pb2,
    pools_pb2_grpc,
    states_pb2,
    states_pb2_grpc,
    step_pb2,
)
from procgen_client._requests import (
    Reset,
    action_bytes,
    clone_pair_messages,
    message_of,
    observation,
    reset_messages,
    step_request,
)
from procgen_client._transport.async_stream import AsyncStream
from procgen_client._transport.encoding import check_decodable
from procgen_client._transport.wire import read_response
from procgen_client._validation import POOL_PAGES_MAX, Expected, check_pool, check_states
from procgen_client.batch import Batch, assemble
from procgen_client.client import STEP_POOL_METHOD, channel_arguments
from procgen_client.credentials import Credentials
from procgen_client.errors import (
    DeadlineExceededError,
    FailedPreconditionError,
    InternalError,
    InvalidArgumentError,
    NotFoundError,
    UnavailableError,
    from_rpc_error,
)
from procgen_client.pool_resource import restore_requests


async def connect(
    address: str,
    *,
    timeout: float = 10.0,
    reconnect_timeout: float = 60.0,
    credentials: Credentials | None = None,
) -> AsyncClient:
    """Connects to a server.

    Args:
        address, timeout, reconnect_timeout, credentials: As procgen_client.Client takes them.

    Errors as procgen_client.Client.
    """
    client = AsyncClient(address, reconnect_timeout=reconnect_timeout, credentials=credentials)
    try:
        await client._read_catalog(timeout)
    except BaseException:
        await client.close()
        raise
    return client


class AsyncClient:
    """A connection to a server; made by :func:`connect`. An asynchronous context manager.

    Tasks: any number of one event loop; a pool belongs to one task at a time.

    Attributes:
        address: What it is connected to.
        reconnect_timeout: How long pools try to go on after a broken connection, in seconds.
    """

    def __init__(
        self,
        address: str,
        *,
        call_timeout: float = 60.0,
        reconnect_timeout: float = 60.0,
        credentials: Credentials | None = None,
    ) -> None:
        """For :func:`connect`."""
        _fork.use_grpc(address)
        self.address = address
        self.reconnect_timeout = reconnect_timeout
        self._call_timeout = call_timeout
        shown = Credentials.from_environment() if credentials is None else credentials
        self._channel = shown.channel(address, channel_arguments(address), grpc.aio)
        self._metadata = shown.metadata()
        self._catalog_stub = catalog_pb2_grpc.CatalogServiceStub(self._channel)
        self._pool_stub = pools_pb2_grpc.PoolServiceStub(self._channel)
        self._state_stub = states_pb2_grpc.StateServiceStub(self._channel)
        self._step_pool = functools.partial(
            self._channel.stream_stream(STEP_POOL_METHOD, response_deserializer=read_response),
            metadata=self._metadata,
        )
        self._catalog = catalog_pb2.Catalog()

    async def __aenter__(self) -> AsyncClient:
        """Gives the client itself."""
        return self

    async def __aexit__(self, *exception: object) -> None:
        """Closes the connection."""
        await self.close()

    async def close(self) -> None:
        """Closes the connection; calls under way end."""
        await self._channel.close()

    def catalog(self) -> catalog_pb2.Catalog:
        """Tells what the server offers, as procgen_client.Client.catalog."""
        return self._catalog

    async def create_pool(
        self,
        games: str | Sequence[str],
        env_count: int = 64,
        *,
        autoreset_mode: str = "same_step",
        requests_in_flight_max: int = 2,
        screen_size: int = 64,
        grayscale_obs: bool = False,
        layout: str = "hwc",
        frame_stack: int = 1,
        encoding: str = "raw",
        lease_duration: float | None = None,
        level_sampler: _options.LevelSampler | None = None,
        **options: Any,
    ) -> AsyncPool:
        """Makes a pool; arguments and errors as procgen_client.Client.create_pool."""
        spec = _options.pool_spec(
            games,
            env_count,
            options=_options.environment_options(**options),
            autoreset_mode=autoreset_mode,
            observation_format=_options.observation_format(
                screen_size, grayscale_obs, layout, frame_stack
            ),
            encoding=encoding,
            lease_duration=lease_duration,
            level_sampler=level_sampler,
        )
        check_decodable(spec.encoding)
        pool = await self._unary(
            self._pool_stub.CreatePool, pools_pb2.CreatePoolRequest(spec=spec)
        )
        check_pool(pool, None, spec.env_count)
        return AsyncPool(
            self, pool, deletes_on_close=True, requests_in_flight_max=requests_in_flight_max
        )

    async def get_pool(self, name: str, *, requests_in_flight_max: int = 2) -> AsyncPool:
        """Gives a pool that is there already; closing it leaves it there."""
        pool = await self._unary(self._pool_stub.GetPool, pools_pb2.GetPoolRequest(name=name))
        check_pool(pool, name)
        return AsyncPool(
            self, pool, deletes_on_close=False, requests_in_flight_max=requests_in_flight_max
        )

    async def list_pools(self) -> list[pools_pb2.Pool]:
        """Tells what pools there are, oldest first."""
        pools: list[pools_pb2.Pool] = []
        request = pools_pb2.ListPoolsRequest()
        for _ in range(POOL_PAGES_MAX):
            response = await self._unary(self._pool_stub.ListPools, request)
            pools += response.pools
            request.page_token = response.next_page_token
            if not request.page_token:
                return pools
        raise InternalError(f"a list of pools has more than {POOL_PAGES_MAX} pages")

    async def _read_catalog(self, timeout: float) -> None:
        try:
            self._catalog = await self._unary(
                self._catalog_stub.GetCatalog,
                catalog_pb2.GetCatalogRequest(),
                timeout=timeout,
                wait_for_ready=True,
            )
        except DeadlineExceededError:
            raise UnavailableError(
                f"no server answers at {self.address}; waited {timeout:g} s"
            ) from None

    async def _unary(
        self, method: Any, request: protobuf_message.Message, **arguments: Any  # noqa: ANN401
    ) -> Any:  # noqa: ANN401
        try:
            return await method(
                request,
                **({"timeout": self._call_timeout, "metadata": self._metadata} | arguments),
            )
        except grpc.RpcError as error:
            raise from_rpc_error(error) from None
        except grpc.aio.UsageError as error:
            raise FailedPreconditionError(
                f"the connection to {self.address} was closed: {error}"
            ) from None


class AsyncPool:
    """A number of environments that are stepped as one batch, as procgen_client.Pool.

    An asynchronous context manager: leaving it deletes a pool that create_pool made.

    Tasks: one at a time.

    Attributes:
        name, spec, env_count, observation_shape, requests_in_flight_max: As Pool's.
    """

    def __init__(
        self,
        client: AsyncClient,
        message: pools_pb2.Pool,
        *,
        deletes_on_close: bool,
        requests_in_flight_max: int,
    ) -> None:
        """For :class:`AsyncClient`; use its create_pool or get_pool."""
        self._message = message
        self.name = message.name
        self.spec = message.spec
        self.env_count = message.spec.env_count
        self.observation_shape = tuple(message.observation_shape)
        self.requests_in_flight_max = requests_in_flight_max
        self._client = client
        self._deletes_on_close = deletes_on_close
        self._stream: AsyncStream | None = None
        self._was_given_up = False  # The last stream; the server may not have noticed it yet.

    async def __aenter__(self) -> AsyncPool:
        """Gives the pool itself."""
        return self

    async def __aexit__(self, *exception: object) -> None:
        """Closes the pool."""
        await self.close()

    @property
    def in_flight(self) -> int:
        """Number of requests whose answers were not received yet."""
        return 0 if self._stream is None else self._stream.in_flight

    async def step(self, actions: npt.ArrayLike, **arguments: Any) -> Batch:
        """Steps environments, and waits for the answer; arguments and errors as Pool.step."""
        self._require_nothing_in_flight()
        await self.send_step(actions, **arguments)
        return await self.receive()

    async def observe(self, *, observe: bool = True) -> Batch:
        """Tells how the pool stands and changes nothing; rewards are the last step's again."""
        self._require_nothing_in_flight()
        request = step_pb2.Observe(observation=observation(observe))
        await self._send(
            step_pb2.StepPoolRequest(observe=request).SerializeToString(),
            Expected(0, self.env_count, observe),
        )
        return await self.receive()

    async def reset(self, resets: Iterable[int | Reset] | None = None) -> Batch:
        """Begins new episodes in some environments (None: all), and tells how the pool stands."""
        self._require_nothing_in_flight()
        which = range(self.env_count) if resets is None else resets
        request = step_pb2.ResetSlice(resets=reset_messages(which))
        await self._send(
            step_pb2.StepPoolRequest(reset=request).SerializeToString(),
            Expected(0, self.env_count, observe=True),
        )
        return await self.receive()

    async def send_step(
        self,
        actions: npt.ArrayLike,
        *,
        first_env: int = 0,
        observe: bool = True,
        repeat_count: int = 1,
        final_observations: bool = False,
        next_levels: Mapping[int, int] | None = None,
        resets: Iterable[int | Reset] = (),
    ) -> None:
        """Sends the request of :meth:`step`; receive gives the answer. Errors as Pool.send_step."""
        on_wire = action_bytes(actions)
        if not 0 <= first_env <= self.env_count - max(len(on_wire), 1) or not on_wire:
            raise InvalidArgumentError(
                f"{len(on_wire)} actions from environment {first_env}; {self.name} has "
                f"{self.env_count} environments"
            )
        request = step_request(
            on_wire,
            first_env,
            repeat_count=repeat_count,
            observe=observe,
            final_observations=final_observations,
            chunk_count=0,
            next_levels=next_levels,
            resets=resets,
        )
        expected = Expected(first_env, len(on_wire), observe, final_observations)
        await self._send(request, expected)

    async def receive(self) -> Batch:
        """Waits for the answer to the oldest unanswered request; errors as Pool.receive."""
        if self._stream is None or not self._stream.in_flight:
            raise FailedPreconditionError(f"no request to {self.name} is unanswered: send first")
        try:
            parts = await self._stream.receive()
        except BaseException:
            self._drop()
            raise
        return assemble(parts, self.observation_shape)

    async def attach(self, *, take_over: bool = False, response_bytes_max: int = 0) -> None:
        """Takes the pool for this object. Never necessary: the first request does so.

        Arguments and errors as Pool.attach.
        """
        if self._stream is not None:
            return
        attach = step_pb2.Attach(
            pool=self.name,
            requests_in_flight_max=self.requests_in_flight_max,
            take_over=take_over or self._was_given_up,
            response_bytes_max=response_bytes_max,
        )
        self._stream = await AsyncStream.open(
            self._client._step_pool, attach, self._message, self._client.reconnect_timeout
        )
        self._was_given_up = False
        self.requests_in_flight_max = self._stream.attached.requests_in_flight_max

    async def save_states(self, environments: Sequence[int] | None = None) -> list[bytes]:
        """Takes snapshots of environments; arguments and errors as Pool.save_states."""
        self._require_nothing_in_flight()
        if environments is not None and len(environments) == 0:
            return []
        request = message_of(
            states_pb2.SaveStatesRequest, pool=self.name, environments=environments
        )
        wanted = range(self.env_count) if environments is None else environments
        snapshots: list[bytes] = []
        while True:
            page = await self._client._unary(self._client._state_stub.SaveStates, request)
            check_states(page, wanted, len(snapshots))
            snapshots += [state.snapshot for state in page.states]
            request.page_token = page.next_page_token
            if not request.page_token:
                return snapshots

    async def restore_states(self, states: Mapping[int, bytes] | Sequence[bytes]) -> None:
        """Puts environments into saved states; arguments and errors as Pool.restore_states."""
        self._require_nothing_in_flight()
        bytes_max = self._client.catalog().limits.request_bytes_max
        for request in restore_requests(self.name, states, self.env_count, bytes_max):
            await self._client._unary(self._client._state_stub.RestoreStates, request)

    async def clone_states(self, pairs: Iterable[tuple[int, int]]) -> None:
        """Puts environments of the pool into the states of others of it; as Pool.clone_states."""
        self._require_nothing_in_flight()
        messages = clone_pair_messages(pairs)
        if messages:
            request = states_pb2.CloneStatesRequest(pool=self.name, pairs=messages)
            await self._client._unary(self._client._state_stub.CloneStates, request)

    async def close(self) -> None:
        """Deletes the pool if create_pool made it; requests in flight are given up."""
        self._drop()
        if not self._deletes_on_close:
            return
        try:
            await self._client._unary(
                self._client._pool_stub.DeletePool, pools_pb2.DeletePoolRequest(name=self.name)
            )
        except (FailedPreconditionError, NotFoundError, UnavailableError):
            pass  # It is gone, or the server is.

    async def _send(self, body: bytes, expected: Expected | None) -> None:
        await self.attach()
        assert self._stream is not None
        if self.in_flight >= self.requests_in_flight_max:
            raise FailedPreconditionError(
                f"{self.in_flight} requests to {self.name} are unanswered, of at most "
                f"{self.requests_in_flight_max}: receive first"
            )
        self._stream.send(body, expected)

    def _drop(self) -> None:
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.drop()
            self._was_given_up = True

    def _require_nothing_in_flight(self) -> None:
        if self.in_flight:
            raise FailedPreconditionError(
                f"{self.in_flight} requests to {self.name} are unanswered: receive them first"
            )
