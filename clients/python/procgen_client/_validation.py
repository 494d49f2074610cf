"""Checks what a server answers, before it is used.

A server may be faulty, of another version, or somebody else's. Whatever it sends, sizes and numbers
fit the request, or the call ends with InternalError: what was given and what was expected.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from procgen_client._proto import pools_pb2, render_pb2, states_pb2, step_pb2
from procgen_client._transport.wire import Part
from procgen_client.errors import InternalError

# The contract's bounds: PoolSpec.total_env_count, ObservationFormat's largest stack of the
# largest pictures in colour, and State.snapshot.
_ENV_COUNT_MAX = 16777216
_OBSERVATION_BYTES_MAX = 16 * 512 * 512 * 3
_SNAPSHOT_BYTES_MAX = 1 << 20
_RESPONSE_BYTES_DEFAULT = 4194304
# A server gives 1000 pools a page; a list beyond this many pages has no end.
POOL_PAGES_MAX = 1000

_ROW_ARRAYS = (
    "rewards",
    "first",
    "terminated",
    "truncated",
    "level_seeds",
    "prev_level_seeds",
    "prev_level_complete",
    "episode_returns",
    "episode_lengths",
)


class Expected(NamedTuple):
    """What a request is answered with. None in its place: it is carried out, and has no values."""

    first_env: int
    env_count: int
    observe: bool
    final_observations: bool = False


def check_pool(pool: pools_pb2.Pool, name: str | None = None, env_count: int = 0) -> None:
    """Checks a pool: its name and its number of environments, if known, and its sizes."""
    if not pool.name or (name is not None and pool.name != name):
        raise InternalError(f"the server answers with pool {pool.name!r}, expected: {name!r}")
    count = pool.spec.env_count
    if not 1 <= count <= _ENV_COUNT_MAX or (env_count and count != env_count):
        raise InternalError(
            f"the server answers with a pool of {count} environments, expected: "
            f"{env_count or f'1 to {_ENV_COUNT_MAX}'}"
        )
    shape = pool.observation_shape
    if not shape or min(shape) < 1 or math.prod(shape) > _OBSERVATION_BYTES_MAX:
        raise InternalError(f"{pool.name} has observations of shape {list(shape)}, which is none")
    if pool.observation_bytes != math.prod(shape):
        raise InternalError(
            f"{pool.name} has observations of {pool.observation_bytes} bytes, expected: "
            f"{math.prod(shape)}"
        )


def check_attached(
    attached: step_pb2.Attached, attach: step_pb2.Attach, known: pools_pb2.Pool
) -> None:
    """Checks that the stream has the pool that is known."""
    check_pool(attached.pool, known.name, known.spec.env_count)
    spec = attached.pool.spec
    if (
        list(attached.pool.observation_shape) != list(known.observation_shape)
        or spec.encoding != known.spec.encoding
        or spec.transport != known.spec.transport
    ):
        raise InternalError(f"{known.name} has another shape, encoding or transport than before")
    bytes_max = attach.response_bytes_max or _RESPONSE_BYTES_DEFAULT
    if attached.requests_in_flight_max < 1 or not 1 <= attached.response_bytes_max <= bytes_max:
        raise InternalError(
            f"{known.name} is attached with {attached.requests_in_flight_max} requests in flight "
            f"and responses of {attached.response_bytes_max} bytes, expected: at least 1, and 1 to "
            f"{bytes_max}"
        )
    shares = spec.transport == pools_pb2.TRANSPORT_SHARED_MEMORY
    if attached.next_sequence_number < 1 or attached.HasField("shared_memory") != shares:
        raise InternalError(
            f"{known.name} is at request {attached.next_sequence_number} and has "
            f"{'shared' if attached.HasField('shared_memory') else 'no shared'} memory, expected: "
            "1 or more, and as its transport says"
        )


def check_part(
    part: Part, expected: Expected, before: Iterable[Part], attached: step_pb2.Attached
) -> None:
    """Checks the next response to a request, after those ``before``."""
    number, count = part.sequence_number, part.env_count
    next_environment = expected.first_env + sum(each.env_count for each in before)
    count_max = expected.first_env + expected.env_count - next_environment
    if part.first_env != next_environment or not 1 <= count <= count_max:
        raise InternalError(
            f"the answer to request {number} has {count} environments from "
            f"{part.first_env}, expected: 1 to {count_max} from {next_environment}"
        )
    if part.last != (count == count_max):
        raise InternalError(
            f"the answer to request {number} {'ends' if part.last else 'goes on'} after "
            f"environment {next_environment + count - 1}, expected: its end after "
            f"{next_environment + count_max - 1}"
        )
    for name in _ROW_ARRAYS:
        _check_size(part, name, (count,))
    ended = int(np.count_nonzero(part.arrays["terminated"] | part.arrays["truncated"]))
    _check_size(part, "fingerprints", (ended, 0))  # None: of a server without them.
    observation_bytes = attached.pool.observation_bytes
    finals = ended * observation_bytes
    _check_size(part, "final_observations", (finals, 0) if expected.final_observations else (0,))
    is_raw = attached.pool.spec.encoding in (
        pools_pb2.ENCODING_UNSPECIFIED,
        pools_pb2.ENCODING_RAW,
    )
    if is_raw or not expected.observe:
        _check_size(part, "observations", (count * observation_bytes if expected.observe else 0,))
    elif not len(part.arrays["observations"]) or (
        # There is room for them as if nothing could be compressed; so few bytes become no more.
        count * observation_bytes > attached.response_bytes_max
    ):
        raise InternalError(
            f"the answer to request {number} has {len(part.arrays['observations'])} bytes of "
            f"{count} encoded observations, expected: some, of no more than "
            f"{attached.response_bytes_max} bytes when decoded"
        )


def check_states(
    page: states_pb2.SaveStatesResponse, environments: Sequence[int], before: int
) -> None:
    """Checks a page of snapshots of these environments, after those of ``before`` of them."""
    count = before + len(page.states)
    is_last = not page.next_page_token
    if not page.states or count > len(environments) or is_last != (count == len(environments)):
        raise InternalError(
            f"the server answers with {len(page.states)} states after {before}"
            f"{'' if is_last else ' and more to come'}, expected: {len(environments)} in all"
        )
    for state, environment in zip(page.states, environments[before:count]):
        if state.environment != environment or not 1 <= len(state.snapshot) <= _SNAPSHOT_BYTES_MAX:
            raise InternalError(
                f"the server answers with {len(state.snapshot)} bytes of environment "
                f"{state.environment}, expected: 1 to {_SNAPSHOT_BYTES_MAX} of {environment}"
            )


def check_frames(
    frames: Sequence[render_pb2.Frame], request: Any  # noqa: ANN401
) -> None:
    """Checks that frames are those that were asked for, raw."""
    size_px = request.size_px
    if len(frames) != len(request.environments):
        raise InternalError(
            f"the server answers with {len(frames)} frames, expected: {len(request.environments)}"
        )
    for frame, environment in zip(frames, request.environments):
        expected = (environment, size_px, 3 * size_px * size_px)
        if (frame.environment, frame.size_px, len(frame.image)) != expected:
            raise InternalError(
                f"the server answers with a frame of environment {frame.environment} of "
                f"{frame.size_px} x {frame.size_px} pixels in {len(frame.image)} bytes, "
                f"expected: {environment}, {size_px} x {size_px} and {3 * size_px * size_px}"
            )


def _check_size(part: Part, name: str, sizes: tuple[int, ...]) -> None:
    if len(part.arrays[name]) not in sizes:
        raise InternalError(
            f"the answer to request {part.sequence_number} has {name} of size "
            f"{len(part.arrays[name])}, expected: {sizes[0]}"
        )
