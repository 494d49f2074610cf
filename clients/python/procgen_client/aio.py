"""Pools for asyncio: stepped while other coroutines run.

    async with await create_pool("coinrun", 64) as pool:
        batch = await pool.step([7] * 64)

    async with await connect("localhost:50051") as client:
        async with await client.create_pool("coinrun", 64) as pool:
            batch = await pool.step([7] * 64)

Batches, options and errors are those of :class:`procgen_client.Pool` and
:class:`procgen_client.Client`, whose calls run on threads here.
"""

from __future__ import annotations

import asyncio
import functools
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, TypeVar

import numpy.typing as npt

from procgen_client._requests import Reset
from procgen_client.batch import Batch
from procgen_client.errors import CancelledError
from procgen_client.objects import Objects
from procgen_client.pool import Pool

if TYPE_CHECKING:
    from procgen_client._proto import catalog_pb2, pools_pb2
    from procgen_client.client import Client
    from procgen_client.credentials import Credentials

_Result = TypeVar("_Result")


async def create_pool(
    games: str | Sequence[str], env_count: int = 64, **arguments: Any
) -> AsyncPool:
    """Makes a pool; arguments and errors as procgen_client.Pool."""
    make = functools.partial(Pool, games, env_count, **arguments)
    return AsyncPool(await asyncio.get_running_loop().run_in_executor(None, make))


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
    from procgen_client.client import Client

    connect_client = functools.partial(
        Client,
        address,
        timeout=timeout,
        reconnect_timeout=reconnect_timeout,
        credentials=credentials,
    )
    return AsyncClient(await asyncio.get_running_loop().run_in_executor(None, connect_client))


class AsyncClient:
    """A connection to a server; made by :func:`connect`. An asynchronous context manager.

    Tasks: any number of one event loop; a pool belongs to one task at a time.

    Attributes:
        client: The procgen_client.Client.
    """

    def __init__(self, client: Client) -> None:
        """For :func:`connect`."""
        self.client = client

    async def __aenter__(self) -> AsyncClient:
        """Returns the client itself."""
        return self

    async def __aexit__(self, *exception: object) -> None:
        """Closes the connection."""
        await self.close()

    async def close(self) -> None:
        """Closes the connection; running calls end with CancelledError."""
        self.client.close()

    def catalog(self) -> catalog_pb2.Catalog:
        """Returns the server's catalog, as procgen_client.Client.catalog."""
        return self.client.catalog()

    async def create_pool(
        self, games: str | Sequence[str], env_count: int = 64, **arguments: Any
    ) -> AsyncPool:
        """Makes a pool; arguments and errors as procgen_client.Client.create_pool."""
        return await create_pool(games, env_count, server=self.client, **arguments)

    async def list_pools(self) -> list[pools_pb2.Pool]:
        """Returns the pools, oldest first."""
        return await asyncio.get_running_loop().run_in_executor(None, self.client.list_pools)


class AsyncPool:
    """N environments that are stepped together, as procgen_client.Pool.

    An asynchronous context manager: leaving it closes the pool.

    Tasks: one at a time. Cancelling a task that waits discards the answers in flight; their steps
    are taken.

    Attributes:
        pool: The procgen_client.Pool, for its attributes.
    """

    def __init__(self, pool: Pool) -> None:
        """Takes the pool, which nothing else may use."""
        self.pool = pool
        # Calls run in order, also those after a task was cancelled.
        self._thread = ThreadPoolExecutor(1, "procgen-pool")

    async def __aenter__(self) -> AsyncPool:
        """Returns the pool itself."""
        return self

    async def __aexit__(self, *exception: object) -> None:
        """Closes the pool."""
        await self.close()

    @property
    def in_flight(self) -> int:
        """Number of requests whose answers were not received."""
        return self.pool.in_flight

    async def step(self, actions: npt.ArrayLike, **arguments: Any) -> Batch:
        """Steps environments, and waits for the batch; arguments and errors as Pool.step."""
        return await self._run(lambda: self.pool.step(actions, **arguments))

    async def observe(self, **arguments: Any) -> Batch:
        """Returns the current state without stepping; arguments and errors as Pool.observe."""
        return await self._run(lambda: self.pool.observe(**arguments))

    async def reset(
        self, resets: Iterable[int | Reset] | None = None, **arguments: Any
    ) -> Batch:
        """Starts new episodes in some environments; arguments and errors as Pool.reset."""
        return await self._run(lambda: self.pool.reset(resets, **arguments))

    async def send_step(self, actions: npt.ArrayLike, **arguments: Any) -> None:
        """Begins a step, for receive; arguments and errors as Pool.send_step."""
        await self._run(lambda: self.pool.send_step(actions, **arguments))

    async def receive(self) -> Batch:
        """Waits for the batch of the oldest unanswered request; errors as Pool.receive."""
        return await self._run(self.pool.receive)

    async def save_states(self, environments: Sequence[int] | None = None) -> list[bytes]:
        """Returns snapshots of environments; arguments and errors as Pool.save_states."""
        return await self._run(lambda: self.pool.save_states(environments))

    async def restore_states(self, states: Mapping[int, bytes] | Sequence[bytes]) -> None:
        """Restores environments from snapshots; arguments and errors as Pool.restore_states."""
        await self._run(lambda: self.pool.restore_states(states))

    async def clone_states(self, pairs: Iterable[tuple[int, int]]) -> None:
        """Copies states between environments of the pool; errors as Pool.clone_states."""
        await self._run(lambda: self.pool.clone_states(pairs))

    async def objects(self, objects_max: int = 64, **arguments: Any) -> Objects:
        """Returns the objects of environments as arrays; arguments and errors as Pool.objects."""
        return await self._run(lambda: self.pool.objects(objects_max, **arguments))

    async def close(self) -> None:
        """Closes the pool, after what is in flight. May be called again."""
        if not self.pool.closed:
            await self._run(self.pool.close)
            self._thread.shutdown(wait=False)

    async def _run(self, call: Callable[[], _Result]) -> _Result:
        """Runs a call of the pool on its thread and waits for it."""
        if self.pool.closed:
            raise CancelledError("the pool was closed")
        try:
            return await asyncio.get_running_loop().run_in_executor(self._thread, call)
        except asyncio.CancelledError:
            self._thread.submit(self.pool._interrupt)
            raise
