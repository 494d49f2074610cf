"""The environments of a learner: a pool whose halves are stepped alternately.

All calls of the client are in this file.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import torch

from procgen_client import Batch, Client, Pool
from procgen_client.errors import (
    DeadlineExceededError,
    FailedPreconditionError,
    InvalidArgumentError,
    NotFoundError,
    ProcgenError,
    UnavailableError,
    UnimplementedError,
)
from procgen_client.tools.evaluate import return_range
from procgen_client.tools.local_server import is_local, open_client

# Errors of a stopped server, after which the pool is created again.
LOST = (UnavailableError, NotFoundError, DeadlineExceededError)
# Time after which the server deletes the pool of a killed learner, in seconds.
_LEASE_DURATION = 300.0
_RETRY_INTERVAL = 1.0


class Environments:
    """A pool in two halves: the server steps one half while the learner processes the other.

    The learner calls :meth:`receive` and :meth:`send` for one half, then for the other. On the
    server's machine observations are in shared memory.

    Attributes:
        env_count: Number of environments, N.
        halves: The rows of each half.
    """

    def __init__(
        self,
        game: str,
        env_count: int,
        *,
        server: str | None = None,
        server_timeout: float = 600.0,
        **options: Any,  # noqa: ANN401
    ) -> None:
        """Creates the pool.

        Args:
            game: Name of the game.
            env_count: Number of environments, at least 2.
            server: Address. None: the variable PROCGEN_SERVER, else a local server.
            server_timeout: Time to wait for a server that stopped, in seconds.
            **options: As for Client.create_pool.

        Raises:
            ProcgenError: As Client and Client.create_pool.
        """
        self.env_count = env_count
        middle = env_count // 2
        self.halves = (slice(0, middle), slice(middle, env_count))
        self._game = game
        self._server = server
        self._server_timeout = server_timeout
        self._options = options
        self._client: Client
        self._pool: Pool
        self._open(None)

    def send_observe(self) -> None:
        """Requests the current observations of both halves: two answers."""
        for rows in self.halves:
            self._pool.send_observe(
                first_env=rows.start, env_count=rows.stop - rows.start
            )

    def send(self, half: int, actions: np.ndarray) -> None:
        """Sends a step of a half; `actions`: int [rows of the half]."""
        self._pool.send_step(actions, first_env=self.halves[half].start)

    def receive(self) -> Batch:
        """Waits for the answer to the oldest request.

        Raises:
            LOST: The server stopped; :meth:`reopen` creates the pool again.
        """
        return self._pool.receive()

    def save_states(self) -> list[bytes]:
        """Returns a snapshot of each environment. No request may be in flight."""
        return self._pool.save_states()

    def return_range(self, mode: str) -> tuple[float, float]:
        """Returns the returns that are normalised to 0 and 1; hard mode's if `mode` has none."""
        own = return_range_or_none(self._client, self._game, mode)
        return own or return_range(self._client.catalog(), self._game, "hard")

    def reopen(self, states: list[bytes] | None) -> None:
        """Creates the pool again, also on a restarted server.

        Args:
            states: Snapshots to restore. None: a new pool's states.

        Raises:
            ProcgenError: No server answered within server_timeout.
        """
        was_local = is_local(self._client)
        deadline = time.monotonic() + (0 if was_local else self._server_timeout)
        self.close()
        while True:
            try:
                return self._open(states)
            except LOST as error:
                if time.monotonic() >= deadline:
                    raise
                print(f"waiting for the server: {error}", file=sys.stderr)
                time.sleep(_RETRY_INTERVAL)

    def close(self) -> None:
        """Deletes the pool, unless the server is unreachable, and disconnects."""
        try:
            self._pool.close()
        except ProcgenError:
            pass  # The pool's lease will expire.
        self._client.close()

    def _open(self, states: list[bytes] | None) -> None:
        self._client = open_client(self._server)
        try:
            self._pool = self._create_pool()
            if states is not None:
                self._pool.restore_states(states)
        except BaseException:
            self._client.close()
            raise

    def _create_pool(self) -> Pool:
        """Creates a pool with shared memory, or with a stream from another machine."""
        try:
            pool = self._client.create_pool(
                self._game,
                self.env_count,
                transport="shared_memory",
                lease_duration=_LEASE_DURATION,
                **self._options,
            )
        except UnimplementedError:
            pass
        else:
            try:
                pool.attach()
                return pool
            except FailedPreconditionError:
                pool.close()
        return self._client.create_pool(
            self._game, self.env_count, lease_duration=_LEASE_DURATION, **self._options
        )


def pool_options(options: argparse.Namespace, rank: int, rank_count: int) -> dict[str, Any]:
    """Returns options of Client.create_pool, for a rank's part of one logical pool."""
    return {
        "distribution_mode": options.mode,
        "num_levels": options.levels,
        "start_level": options.start_level,
        "use_sequential_levels": options.sequential_levels,
        "rand_seed": options.seed,
        "first_env": rank * options.num_envs,
        "total_env_count": rank_count * options.num_envs,
    }


def tensor_of(batch: Batch) -> torch.Tensor:
    """Returns the observations, uint8 [n, 64, 64, 3], without a copy; read-only."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # PyTorch warns of read-only arrays.
        return torch.from_numpy(batch.observations)


class Episode(NamedTuple):
    """An episode that ended in an update of a learner."""

    t: int  # Step of the update in which it ended, from 1.
    environment: int  # Index in the pool.
    level_seed: int
    episode_return: float
    length: int  # In steps.


def episodes_of(batch: Batch, t: int, first: int) -> list[Episode]:
    """Returns the episodes that ended in a batch, whose first row is environment `first`."""
    return [
        Episode(
            t,
            first + int(row),
            int(batch.prev_level_seeds[row]),
            float(batch.episode_returns[row]),
            int(batch.episode_lengths[row]),
        )
        for row in np.flatnonzero(batch.ended)
    ]


def play_episodes(
    client: Client,
    game: str,
    act: Callable[[np.ndarray], Any],
    *,
    env_count: int,
    each: int,
    **options: Any,  # noqa: ANN401
) -> np.ndarray:
    """Plays the same number of episodes in each environment.

    Args:
        client: Connection to the server.
        game: Name of the game.
        act: From observations, uint8 [N, 64, 64, 3], to actions, int [N].
        env_count: Number of environments, N.
        each: Episodes per environment.
        **options: As for Client.create_pool.

    Returns:
        The episodes' returns, float32 [N, each].
    """
    returns = np.zeros((env_count, each), np.float32)
    played = np.zeros(env_count, np.int64)
    with client.create_pool(game, env_count, **options) as pool:
        batch = pool.observe()
        while (played < each).any():
            batch = pool.step(act(batch.observations))
            rows = np.flatnonzero(batch.ended & (played < each))
            returns[rows, played[rows]] = batch.episode_returns[rows]
            played[rows] += 1
    return returns


def games_with_mode(client: Client, mode: str) -> list[str]:
    """Returns the games that have a distribution mode."""
    return [
        game.name
        for game in client.catalog().games
        if any(_mode_name(its_mode) == mode for its_mode in game.modes)
    ]


def return_range_or_none(client: Client, game: str, mode: str) -> tuple[float, float] | None:
    """Returns the returns that the paper normalises to 0 and 1; None: not for this mode."""
    try:
        return return_range(client.catalog(), game, mode)
    except InvalidArgumentError:
        return None


def _mode_name(mode: Any) -> str:  # noqa: ANN401 - a message of the catalog
    names = mode.DESCRIPTOR.fields_by_name["distribution_mode"].enum_type.values_by_number
    return names[mode.distribution_mode].name.removeprefix("DISTRIBUTION_MODE_").lower()
