"""The environments of a learner: a pool whose halves are stepped alternately."""

from __future__ import annotations

import argparse
import os
from typing import Any, NamedTuple

import numpy as np

from procgen_client import Batch, DoubleBufferedSampler, Pool, ServerProcess, catalog
from procgen_client._place import SERVER_VARIABLE
from procgen_client.errors import InvalidArgumentError
from procgen_client.tools.evaluation import return_range


class Environments(DoubleBufferedSampler):
    """A pool in two halves, and its connection.

    Attributes:
        can_be_watched: Whether they are on a server, whose viewers see annotations.
    """

    def __init__(
        self,
        game: str,
        env_count: int,
        *,
        server: str | None = None,
        server_timeout: float = 600.0,
        watch: str | None = None,
        **options: Any,  # noqa: ANN401
    ) -> None:
        """Makes the pool.

        Args:
            game: Name of the game.
            env_count: Number of environments, at least 2.
            server: Address. None: the variable PROCGEN_SERVER, else this process.
            server_timeout: Time to wait for a server that stopped, in seconds.
            watch: HOST:PORT of pages for browsers: starts a server that has them, and steps there.
            **options: As for Pool.

        Raises:
            ProcgenError: As Pool, and as ServerProcess; InvalidArgumentError: `watch` with a
                server.
        """
        self._game = game
        server = server or os.environ.get(SERVER_VARIABLE)
        self._server = self._client = None
        if watch:
            if server:
                raise InvalidArgumentError(
                    f"watch is {watch} with a server at {server}, which has pages of its own: "
                    "allowed with environments in this process"
                )
            self._server = ServerProcess(web_address=watch, tied=True)
            server = self._server.address
            print(f"Pages: http://{watch}", flush=True)
        if server:
            from procgen_client import Client  # Needs Protocol Buffers.

            self._client = Client(server, reconnect_timeout=server_timeout)
        self.can_be_watched = self._client is not None
        super().__init__(Pool(game, env_count, server=self._client, **options))

    def return_range(self, mode: str) -> tuple[float, float]:
        """Returns the returns that are normalised to 0 and 1; hard mode's if `mode` has none."""
        return return_range_or_none(self._game, mode) or return_range(self._game, "hard")

    def close(self) -> None:
        """Closes the pool, and its connection."""
        self.pool.close()
        if self._client is not None:
            self._client.close()
        if self._server is not None:
            self._server.stop()


def environment_options(
    options: argparse.Namespace, rank: int, rank_count: int
) -> dict[str, Any]:
    """Returns options of Environments, for a rank's part of one logical pool.

    The ranks of a host share its cores.
    """
    ranks_here = int(os.environ.get("LOCAL_WORLD_SIZE", 1))
    threads = max(len(os.sched_getaffinity(0)) // ranks_here - 1, 0)
    frames = getattr(options, "frame_stack", 1)
    return {
        **({"frame_stack": frames} if frames > 1 else {}),
        **({"num_threads": threads} if ranks_here > 1 else {}),
        "server": options.server,
        "server_timeout": options.server_timeout,
        "watch": options.watch if rank == 0 else None,
        "distribution_mode": options.mode,
        "num_levels": options.levels,
        "start_level": options.start_level,
        "use_sequential_levels": options.sequential_levels,
        "rand_seed": options.seed,
        "first_env": rank * options.num_envs,
        "total_env_count": rank_count * options.num_envs,
    }


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


def games_with_mode(mode: str) -> list[str]:
    """Returns the games that have a distribution mode."""
    return [game["name"] for game in catalog()["games"] if mode in game["modes"]]


def return_range_or_none(game: str, mode: str) -> tuple[float, float] | None:
    """Returns the returns that the paper normalises to 0 and 1; None: not for this mode."""
    try:
        return return_range(game, mode)
    except InvalidArgumentError:
        return None
