"""Arguments of requests, and their bounds."""

from __future__ import annotations

import operator
from typing import NamedTuple

from procgen_client.errors import InvalidArgumentError

# Actions are in [ACTION_MIN, ACTION_COUNT). ACTION_MIN ends the episode without a move.
ACTION_MIN = -1
ACTION_COUNT = 15
# Least and largest level seed.
LEVEL_SEEDS = (-(2**31), 2**31 - 1)
# Upper bound of a number of environments in a request; a server has a lower one.
ENV_COUNT_MAX = 2**31 - 1


class Reset(NamedTuple):
    """An environment that starts a new episode at once."""

    environment: int  # Index in the pool, in [0, env_count).
    level_seed: int | None = None  # Level to play. None: chosen as at an episode's end.
    rand_seed: int | None = None  # New seed of its choice of levels. None: unchanged.


def in_range(name: str, given: object, least: int, most: int) -> int:
    """Returns `given`; raises InvalidArgumentError unless it is an integer in [least, most]."""
    try:
        number = operator.index(given)  # type: ignore[arg-type]
    except TypeError:
        raise InvalidArgumentError(
            f"{name} is {given!r}; it is an integer in [{least}, {most}]"
        ) from None
    if not least <= number <= most:
        raise InvalidArgumentError(f"{name} is {given}; it is in [{least}, {most}]")
    return number
