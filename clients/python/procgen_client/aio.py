"""Pools for asyncio: stepped while other coroutines run.

    async with await create_pool("coinrun", 64) as pool:
        batch = await pool.step([7] * 64)

Batches, options and errors are those of :class:`procgen_client.Pool`, whose calls run on a thread
here.
"""

from __future__ import annotations

import asyncio
import functools
from collections.abc import Callable, Coroutine, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, TypeVar

from procgen_client.errors import CancelledError
from procgen_client.pool import Pool

if TYPE_CHECKING:
    from typing_extensions import Concatenate, ParamSpec

    _Parameters = ParamSpec("_Parameters")

_Result = TypeVar("_Result")


async def create_pool(
    games: str | Sequence[str], env_count: int = 64, **arguments: Any
) -> AsyncPool:
    """Makes a pool; arguments and errors as procgen_client.Pool."""
    make = functools.partial(Pool, games, env_count, **arguments)
    return AsyncPool(await asyncio.get_running_loop().run_in_executor(None, make))


def _on_thread(
    method: Callable[Concatenate[Pool, _Parameters], _Result]
) -> Callable[Concatenate[AsyncPool, _Parameters], Coroutine[Any, Any, _Result]]:
    """Returns a method of AsyncPool that calls one of its pool."""

    @functools.wraps(method)
    async def call(
        self: AsyncPool, /, *arguments: _Parameters.args, **keywords: _Parameters.kwargs
    ) -> _Result:
        return await self._run(lambda: method(self.pool, *arguments, **keywords))

    return call


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

    step = _on_thread(Pool.step)
    observe = _on_thread(Pool.observe)
    reset = _on_thread(Pool.reset)
    send_step = _on_thread(Pool.send_step)
    receive = _on_thread(Pool.receive)
    save_states = _on_thread(Pool.save_states)
    restore_states = _on_thread(Pool.restore_states)
    clone_states = _on_thread(Pool.clone_states)
    objects = _on_thread(Pool.objects)

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
