"""The pool of an environment."""

from __future__ import annotations

from procgen_client.catalog import catalog
from procgen_client.envs._gymnasium import AutoresetMode
from procgen_client.errors import InvalidArgumentError
from procgen_client.pool import Pool


def time_limit_steps(pool: Pool) -> int:
    """Returns the number of steps after which the first game's episodes are truncated."""
    mode = pool.options.get("distribution_mode", "hard")
    (game,) = (each for each in catalog()["games"] if each["name"] == pool.games[0])
    return game["modes"][mode]["time_limit_steps"]


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
