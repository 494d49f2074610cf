"""The pool of a Gymnasium environment: made, and closed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from procgen_client.client import Client
from procgen_client.envs._gymnasium import AutoresetMode
from procgen_client.errors import InvalidArgumentError, UnimplementedError
from procgen_client.pool import Pool

_AUTORESET_MODES = {
    AutoresetMode.NEXT_STEP: "next_step",
    AutoresetMode.SAME_STEP: "same_step",
    AutoresetMode.DISABLED: "disabled",
}


def create_pool(
    client: Client,
    games: str | Sequence[str],
    num_envs: int,
    mode: AutoresetMode,
    options: dict[str, Any],
    *,
    is_drawn: bool,
) -> Pool:
    """Creates the pool; errors as Client.create_pool.

    Raises:
        UnimplementedError: `is_drawn`, and the server has no rendering.
    """
    if is_drawn and not client.catalog().features.render:
        raise UnimplementedError(
            f"the server at {client.address} has no rendering; use render_mode None"
        )
    # Views: `copy` of the environment decides whether observations are copied.
    return client.create_pool(
        games, num_envs, autoreset_mode=_AUTORESET_MODES[mode], copy=False, **options
    )


def time_limit_steps(pool: Pool) -> int:
    """Returns the number of steps after which the first game's episodes are truncated."""
    game, mode = pool.spec.games[0], pool.spec.options.distribution_mode
    (steps,) = (
        int(each.time_limit_steps)
        for facts in pool._client.catalog().games
        for each in facts.modes
        if (facts.name, each.distribution_mode) == (game, mode)
    )
    return steps


def close_pool(pool: Pool, client: Client | None) -> None:
    """Closes the pool, and the client unless it is None."""
    pool.close()
    if client is not None:
        client.close()


def check_render_mode(given: str | None) -> None:
    """Raises InvalidArgumentError unless it is None or "rgb_array"."""
    if given not in (None, "rgb_array"):
        raise InvalidArgumentError(f"render_mode is {given!r}; it is None or 'rgb_array'")


def autoreset_mode_of(given: AutoresetMode | str) -> AutoresetMode:
    """Returns the mode; raises InvalidArgumentError if there is none."""
    try:
        return AutoresetMode(given)
    except ValueError:
        values = ", ".join(repr(mode.value) for mode in AutoresetMode)
        raise InvalidArgumentError(
            f"autoreset_mode is {given!r}; it is a member of AutoresetMode or one of {values}"
        ) from None
