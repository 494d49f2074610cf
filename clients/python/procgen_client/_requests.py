"""Parts of requests, made and checked."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from procgen_client._proto import states_pb2, step_pb2
from procgen_client._transport.wire import bytes_field, number_tag, varint
from procgen_client._validation import Expected
from procgen_client.errors import InvalidArgumentError

# Actions are in [ACTION_MIN, ACTION_COUNT). ACTION_MIN does nothing and ends the episode.
ACTION_MIN = -1
ACTION_COUNT = 15

# By action, and the last one is that of -1: what signed numbers are on the wire (sint32). In
# between is what numpy finds for numbers that are no actions.
_NO_ACTION = 0xFF
_ACTIONS_ON_WIRE = np.array([*range(0, 2 * ACTION_COUNT, 2), *[_NO_ACTION] * 100, 1], np.uint8)
_ACTIONS_NUMBER = step_pb2.Step.DESCRIPTOR.fields_by_name["actions"].number
_FIELDS = step_pb2.StepPoolRequest.DESCRIPTOR.fields_by_name
_STEP_NUMBER = _FIELDS["step"].number
_SEQUENCE_NUMBER_TAG = number_tag(_FIELDS["sequence_number"].number)


class Request(NamedTuple):
    """A request that may have to be sent again."""

    sequence_number: int
    head: bytes  # The number as a field, which stands in a response as it does in a request.
    body: bytes  # A serialised StepPoolRequest without numbers.
    expected: Expected | None

    @classmethod
    def numbered(cls, sequence_number: int, body: bytes, expected: Expected | None) -> Request:
        """Gives what is asked for a number."""
        head = _SEQUENCE_NUMBER_TAG + varint(sequence_number)
        return cls(sequence_number, head, body, expected)


class Reset(NamedTuple):
    """An environment that begins a new episode at once."""

    environment: int  # Index in the pool, in [0, env_count).
    level_seed: int | None = None  # Level to play. None: chosen as at an episode's end.
    rand_seed: int | None = None  # Seeds its choice of levels anew. None: goes on as it is.


def action_bytes(actions: npt.ArrayLike) -> bytes:
    """Checks actions and gives them as they are on the wire, a byte for each.

    Raises:
        InvalidArgumentError: They are not one integer for each environment, or out of range.
    """
    array = np.asarray(actions)
    if array.ndim != 1 or array.dtype.kind not in "iu":
        raise InvalidArgumentError(
            f"actions has shape {list(array.shape)} and type {array.dtype}; it is one integer for "
            "each environment"
        )
    try:
        on_wire = _ACTIONS_ON_WIRE.take(array).tobytes()
    except (IndexError, TypeError):  # Further out than the table; 64 bits without a sign.
        on_wire = bytes((_NO_ACTION,))
    if _NO_ACTION in on_wire:
        wrong = np.flatnonzero((array < ACTION_MIN) | (array >= ACTION_COUNT))
        if wrong.size:
            raise InvalidArgumentError(
                f"actions[{wrong[0]}] is {array[wrong[0]]}; actions are {ACTION_MIN} ... "
                f"{ACTION_COUNT - 1}"
            )
        on_wire = _ACTIONS_ON_WIRE.take(array.astype(np.int64)).tobytes()
    return on_wire


@functools.lru_cache(maxsize=64)
def _step_fields(
    first_env: int,
    env_count: int,
    repeat_count: int,
    observe: bool,
    final_observations: bool,
    chunk_count: int,
) -> bytes:
    """Gives what is the same from step to step: a request but for its end, the actions."""
    fields = step_pb2.Step(
        slice=step_pb2.Slice(first_env=first_env, env_count=env_count),
        repeat_count=repeat_count,
        observation=observation(observe),
        with_final_observations=final_observations,
        chunk_count=chunk_count,
    ).SerializeToString()
    step = fields + bytes_field(_ACTIONS_NUMBER, bytes(env_count))
    whole = bytes_field(_STEP_NUMBER, step)
    return whole[: len(whole) - env_count]


def step_request(
    actions: bytes,
    first_env: int,
    *,
    repeat_count: int,
    observe: bool,
    final_observations: bool,
    chunk_count: int,
    next_levels: Mapping[int, int] | None,
    resets: Iterable[int | Reset],
) -> bytes:
    """Gives a StepPoolRequest with a step, serialised, without its number.

    Args:
        actions: From action_bytes.
        first_env, ...: As Pool.step takes them.

    Raises:
        InvalidArgumentError: A number does not fit its field.
    """
    step = (
        _step_fields(
            first_env,
            len(actions),
            in_range("repeat_count", repeat_count, 1, 1000),
            bool(observe),
            bool(final_observations),
            chunk_count,
        )
        + actions
    )
    if not next_levels and resets == ():
        return step
    exceptions = step_pb2.Step(
        next_levels=[
            message_of(step_pb2.NextLevel, environment=environment, level_seed=level_seed)
            for environment, level_seed in (next_levels or {}).items()
        ],
        resets=reset_messages(resets),
    )
    # A message that comes twice is merged.
    return step + bytes_field(_STEP_NUMBER, exceptions.SerializeToString())


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
