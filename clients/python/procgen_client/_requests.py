"""Messages of requests, and the validation of their arguments."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from procgen_client._proto import states_pb2, step_pb2
from procgen_client.errors import InvalidArgumentError

_Message = TypeVar("_Message")

# Actions are in [ACTION_MIN, ACTION_COUNT). ACTION_MIN ends the episode without a move.
ACTION_MIN = -1
ACTION_COUNT = 15
# Least and largest level seed.
LEVEL_SEEDS = (-(2**31), 2**31 - 1)
# Upper bound of a number of environments in a message; the server has a lower one.
ENV_COUNT_MAX = 2**31 - 1


class Reset(NamedTuple):
    """An environment that starts a new episode at once."""

    environment: int  # Index in the pool, in [0, env_count).
    level_seed: int | None = None  # Level to play. None: chosen as at an episode's end.
    rand_seed: int | None = None  # New seed of its choice of levels. None: unchanged.


def checked_actions(actions: np.ndarray) -> np.ndarray:
    """Returns `actions` after validation. The native module validates them itself.

    Raises:
        InvalidArgumentError: Not one integer in range for each environment.
    """
    if actions.ndim != 1 or actions.dtype.kind not in "iu":
        raise InvalidArgumentError(
            f"actions has shape {list(actions.shape)} and type {actions.dtype}; it is one integer "
            "for each environment"
        )
    for wrong in np.flatnonzero((actions < ACTION_MIN) | (actions >= ACTION_COUNT)):
        raise InvalidArgumentError(
            f"actions[{wrong}] is {actions[wrong]}; actions are {ACTION_MIN} ... {ACTION_COUNT - 1}"
        )
    return actions


def optional_step_fields(
    next_levels: Mapping[int, int] | None,
    resets: Iterable[int | Reset],
    annotations: Mapping[str, npt.ArrayLike] | None,
    env_count: int,
) -> bytes:
    """Returns these fields as a serialised Step of `env_count` environments.

    Raises:
        InvalidArgumentError: As message_of and _annotation_messages.
    """
    step = step_pb2.Step(
        next_levels=[
            message_of(step_pb2.NextLevel, environment=environment, level_seed=level_seed)
            for environment, level_seed in (next_levels or {}).items()
        ],
        resets=reset_messages(resets),
        annotations=_annotation_messages(annotations or {}, env_count),
    )
    serialised: bytes = step.SerializeToString()
    return serialised


def _annotation_messages(
    annotations: Mapping[str, npt.ArrayLike], env_count: int
) -> list[step_pb2.Annotation]:
    """Returns annotations as messages; the server checks names and numbers of values.

    Raises:
        InvalidArgumentError: Not one number, or one row of numbers, for each environment.
    """
    messages = []
    for name, given in annotations.items():
        try:
            values = np.asarray(given)
        except ValueError as error:
            raise InvalidArgumentError(f"annotations[{name!r}] is no array: {error}") from error
        if values.ndim not in (1, 2) or len(values) != env_count or values.dtype.kind not in "biuf":
            raise InvalidArgumentError(
                f"annotations[{name!r}] has shape {list(values.shape)} and type {values.dtype}; it "
                f"has one number, or one row of numbers, for each of {env_count} environments"
            )
        messages.append(message_of(step_pb2.Annotation, name=name, values=values.ravel().tolist()))
    return messages


def reset_messages(resets: Iterable[int | Reset]) -> list[step_pb2.Reset]:
    """Returns resets as messages; errors as message_of."""
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
    """Returns snapshots and their environments as messages; errors as message_of.

    Raises:
        InvalidArgumentError: A sequence does not have env_count entries.
    """
    if not isinstance(states, Mapping):
        if len(states) != env_count:
            raise InvalidArgumentError(
                f"states has {len(states)} entries; there are {env_count} environments (a dict "
                "restores some of them)"
            )
        states = dict(enumerate(states))
    return [
        message_of(states_pb2.State, environment=environment, snapshot=snapshot)
        for environment, snapshot in states.items()
    ]


def clone_pair_messages(pairs: Iterable[tuple[int, int]]) -> list[states_pb2.ClonePair]:
    """Returns (source, target) pairs as messages; errors as message_of."""
    return [
        message_of(states_pb2.ClonePair, source_environment=source, target_environment=target)
        for source, target in pairs
    ]


def observation(observe: bool) -> step_pb2.Observation:
    """Returns the field `observation` of a request."""
    return step_pb2.OBSERVATION_FRAME if observe else step_pb2.OBSERVATION_NONE


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


def message_of(cls: Callable[..., _Message], **fields: Any) -> _Message:  # noqa: ANN401
    """Makes a message; raises InvalidArgumentError for a value that does not fit its field."""
    try:
        return cls(**fields)
    except (TypeError, ValueError) as error:
        raise InvalidArgumentError(f"{cls.__name__} has a wrong value: {error}") from error
