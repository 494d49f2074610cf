"""Parts of requests, made and checked."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from procgen_client._proto import states_pb2, step_pb2
from procgen_client.errors import InvalidArgumentError

# Actions are in [ACTION_MIN, ACTION_COUNT). ACTION_MIN does nothing and ends the episode.
ACTION_MIN = -1
ACTION_COUNT = 15


class Reset(NamedTuple):
    """An environment that begins a new episode at once."""

    environment: int  # Index in the pool, in [0, env_count).
    level_seed: int | None = None  # Level to play. None: chosen as at an episode's end.
    rand_seed: int | None = None  # Seeds its choice of levels anew. None: goes on as it is.


def action_numbers(actions: npt.ArrayLike) -> list[int]:
    """Checks actions and gives them as a list.

    Raises:
        InvalidArgumentError: They are not one integer for each environment, or out of range.
    """
    array = np.asarray(actions)
    if array.ndim != 1 or array.dtype.kind not in "iu":
        raise InvalidArgumentError(
            f"actions has shape {list(array.shape)} and type {array.dtype}; it is one integer for "
            "each environment"
        )
    wrong = np.flatnonzero((array < ACTION_MIN) | (array >= ACTION_COUNT))
    if len(wrong):
        raise InvalidArgumentError(
            f"actions[{wrong[0]}] is {array[wrong[0]]}; actions are {ACTION_MIN} ... "
            f"{ACTION_COUNT - 1}"
        )
    return array.tolist()


def reset_messages(resets: Iterable[int | Reset]) -> list[step_pb2.Reset]:
    """Gives resets as messages; errors as message_of."""
    messages = []
    for reset in resets:
        environment, level_seed, rand_seed = (
            reset if isinstance(reset, Reset) else Reset(int(reset))
        )
        messages.append(
            message_of(
                step_pb2.Reset,
                environment=environment,
                level_seed=level_seed,
                rand_seed=rand_seed,
            )
        )
    return messages


def state_messages(
    states: Mapping[int, bytes] | Sequence[bytes], env_count: int
) -> list[states_pb2.State]:
    """Gives snapshots with their environments as messages; errors as message_of.

    Raises:
        InvalidArgumentError: A sequence does not have one for each of env_count environments.
    """
    if not isinstance(states, Mapping):
        if len(states) != env_count:
            raise InvalidArgumentError(
                f"states has {len(states)} entries; there are {env_count} environments (a dict "
                "gives some of them theirs)"
            )
        states = dict(enumerate(states))
    return [
        message_of(states_pb2.State, environment=environment, snapshot=snapshot)
        for environment, snapshot in states.items()
    ]


def clone_pair_messages(pairs: Iterable[tuple[int, int]]) -> list[states_pb2.ClonePair]:
    """Gives (source, target) pairs as messages; errors as message_of."""
    return [
        message_of(states_pb2.ClonePair, source_environment=source, target_environment=target)
        for source, target in pairs
    ]


def observation(observe: bool) -> step_pb2.Observation:
    """Gives what is answered of the pictures."""
    return step_pb2.OBSERVATION_FRAME if observe else step_pb2.OBSERVATION_NONE


def in_range(name: str, given: int, least: int, most: int) -> int:
    """Gives a number back that is in [least, most]; any other is an InvalidArgumentError."""
    if not least <= given <= most:
        raise InvalidArgumentError(f"{name} is {given}; it is in [{least}, {most}]")
    return given


def message_of(cls: Any, **fields: Any) -> Any:  # noqa: ANN401
    """Makes a message; a number that does not fit its field is an InvalidArgumentError."""
    try:
        return cls(**fields)
    except (TypeError, ValueError) as error:
        raise InvalidArgumentError(f"{cls.DESCRIPTOR.name} has a wrong value: {error}") from error
