"""Steps of a pool within jitted JAX programs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import numpy as np
from jax.experimental import io_callback

from procgen_client._place import Server
from procgen_client._requests import Reset
from procgen_client.adapters._xla import XlaPool
from procgen_client.batch import Batch
from procgen_client.options import PoolOptions
from procgen_client.tools.art import Art

if TYPE_CHECKING:
    from typing_extensions import Unpack


class TimeStep(NamedTuple):
    """Arrays of N environments; a pytree."""

    observation: Any  # Current one; of the next episode where one ended uint8   [N, 64, 64, 3]
    reward: Any  # Of this step; of the ended episode where one ended     float32 [N]
    terminated: Any  # The game ended the episode                         bool    [N]
    truncated: Any  # The time limit ended the episode                    bool    [N]
    level_seed: Any  # Level in the observation                           int32   [N]


class ProcgenJaxEnv:
    """N environments whose methods may be called in jit and in lax.scan.

    Each call is an ordered io_callback: the pool steps on the host, in the order of the program.
    :meth:`xla` steps without Python. Not for vmap, grad or pmap: the environments are the batch,
    and there is one of them. Threads: one at a time.

    Attributes:
        pool: The Pool, with autoreset_mode "same_step".
    """

    def __init__(
        self,
        games: str | Sequence[str],
        num_envs: int = 64,
        *,
        server: Server = None,
        art: Art | None = None,
        **options: Unpack[PoolOptions],
    ) -> None:
        """Makes the environments; arguments and errors as Pool."""
        self.pool = XlaPool(games, num_envs, server=server, art=art, **options)
        self._results = jax.tree_util.tree_map(
            lambda array: jax.ShapeDtypeStruct(array.shape, array.dtype),
            _time_step(self.pool.observe()),
        )

    def observe(self) -> TimeStep:
        """Returns the current state, which is the first one before any step."""
        return self._call(lambda: self.pool.observe())

    def reset(self, seed: Any = None) -> TimeStep:  # noqa: ANN401 - an integer, maybe traced
        """Starts new episodes; `seed` + i seeds the choice of levels of environment i."""
        if seed is None:
            return self._call(lambda: self.pool.reset())
        return self._call(self._reset, seed)

    def step(self, actions: Any) -> TimeStep:  # noqa: ANN401 - a JAX array
        """Steps with actions int [N], each in [0, 15), or -1, which ends an episode."""
        return self._call(lambda given: self.pool.step(np.asarray(given)), actions)

    def xla(self) -> tuple[Any, Callable[[Any, Any], tuple[Any, TimeStep]]]:
        """Returns a handle and a function that steps without Python, for programs on the CPU.

        ``handle, time_step = step(handle, actions)`` is a custom call of XLA. Each call takes the
        handle that the one before returned, which orders the calls; another one is an error. The
        first call compiles a file of C, in a fraction of a second.

        Raises:
            FailedPreconditionError: There is no C compiler.
        """

        def step(handle: Any, actions: Any) -> tuple[Any, TimeStep]:  # noqa: ANN401 - JAX arrays
            given = jax.numpy.asarray(actions)
            handle, *fields = self.pool.xla_step(self._results, handle, given)
            return handle, TimeStep(*fields)

        return self.pool.xla_handle(), step

    def close(self) -> None:
        """Closes the pool. Closing again does nothing."""
        self.pool.close()

    def _reset(self, seed: Any) -> Batch:  # noqa: ANN401
        first = int(seed)
        return self.pool.reset(
            [Reset(i, rand_seed=first + i) for i in range(self.pool.env_count)]
        )

    def _call(self, function: Any, *arguments: Any) -> TimeStep:  # noqa: ANN401
        result: TimeStep = io_callback(
            lambda *given: _time_step(function(*given)), self._results, *arguments, ordered=True
        )
        return result


def _time_step(batch: Batch) -> TimeStep:
    return TimeStep(
        batch.observations, batch.rewards, batch.terminated, batch.truncated, batch.level_seeds
    )
