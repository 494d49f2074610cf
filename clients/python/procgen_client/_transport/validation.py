"""Validates responses before their use: a server may be faulty, hostile or of another version.

All functions but `parse` raise InternalError; its message has the value given and the values
expected. The native module validates by itself.
"""

from __future__ import annotations

import math
from typing import TypeVar, cast

from google.protobuf.message import DecodeError, Message

from procgen_client._proto import pools_pb2, render_pb2, states_pb2, step_pb2
from procgen_client.errors import DataLossError, InternalError

_Message = TypeVar("_Message", bound=Message)
# Bounds of the API: PoolSpec.total_env_count, the largest observation that ObservationFormat
# allows, State.snapshot, and Frame.size_px.
_ENV_COUNT_MAX = 16777216
_OBSERVATION_BYTES_MAX = 16 * 512 * 512 * 3
_SNAPSHOT_BYTES_MAX = 1 << 20
_FRAME_SIZE_PX_MAX = 2048
# A page has 1000 pools; a list with more pages is treated as endless.
PAGES_MAX = 1000
# Responses of kinds that only newer clients know, before one answer.
NOTICES_MAX = 1000

_ROWS = (
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


def _require(holds: bool, given: str, expected: object) -> None:  # noqa: FBT001
    if not holds:
        raise InternalError(f"the server's answer: {given}, expected: {expected}")


def parse(message_type: type[_Message], serialised: bytes, sender: str) -> _Message:
    """Parses a response of this method or pool. Raises DataLossError: it is malformed."""
    try:
        return cast(_Message, message_type.FromString(serialised))
    except DecodeError as error:
        raise DataLossError(f"a response of {sender}: {error}") from None


def check_pool(pool: pools_pb2.Pool, name: str = "") -> None:
    """Checks a pool of this name; empty: any name."""
    _require(bool(pool.name) and name in ("", pool.name), f"pool {pool.name!r}", repr(name))
    count = pool.spec.env_count
    _require(1 <= count <= _ENV_COUNT_MAX, f"{count} environments", f"1 to {_ENV_COUNT_MAX}")
    size, shape = pool.observation_bytes, list(pool.observation_shape)
    _require(
        bool(shape) and min(shape) > 0 and math.prod(shape) == size <= _OBSERVATION_BYTES_MAX,
        f"observations of {size} bytes and shape {shape}",
        f"the product of the shape, at most {_OBSERVATION_BYTES_MAX}",
    )


def check_attached(attached: step_pb2.Attached, name: str) -> None:
    """Checks the answer to attach, for a stream without shared memory."""
    check_pool(attached.pool, name)
    _require(not attached.HasField("shared_memory"), "shared memory", "none")
    for field in ("requests_in_flight_max", "next_sequence_number"):
        value = getattr(attached, field)
        _require(value >= 1, f"{field} {value}", "at least 1")


def check_part(
    part: step_pb2.StepPoolResponse,
    request: step_pb2.StepPoolRequest,
    env_count_before: int,
    pool: pools_pb2.Pool,
) -> None:
    """Checks the next response to a request, after responses with `env_count_before` rows."""
    kind = str(request.WhichOneof("request"))
    wanted = "ack" if kind == "level_sampler" else "batch"
    _require(
        part.WhichOneof("response") == wanted and part.sequence_number == request.sequence_number,
        f"{part.WhichOneof('response')} for request {part.sequence_number} of {pool.name}",
        f"{wanted} for request {request.sequence_number}",
    )
    if wanted == "batch":
        _check_batch(part.batch, getattr(request, kind), env_count_before, pool)


def _check_batch(
    batch: step_pb2.Batch,
    body: step_pb2.Step | step_pb2.Reset | step_pb2.Observe,
    env_count_before: int,
    pool: pools_pb2.Pool,
) -> None:
    begin = body.slice.first_env + env_count_before
    left = (body.slice.env_count or pool.spec.env_count - body.slice.first_env) - env_count_before
    count = batch.env_count
    _require(
        batch.first_env == begin
        and 1 <= count <= left
        and batch.last == (count == left)
        and not batch.HasField("shared_batch"),
        f"{count} environments from {batch.first_env}, last: {batch.last}",
        f"1 to {left} from {begin}",
    )
    ended = sum(t or u for t, u in zip(batch.terminated, batch.truncated, strict=False))
    size = pool.observation_bytes
    is_blind = body.observation == step_pb2.OBSERVATION_NONE
    finals = {0}
    if isinstance(body, step_pb2.Step) and body.with_final_observations:
        finals.add(ended * size)
    sizes = {name: {count} for name in _ROWS}
    sizes["fingerprints"] = {0, ended}  # 0: a server without fingerprints.
    sizes["observations"] = {0 if is_blind else count * size}
    sizes["final_observations"] = finals
    for name, expected in sizes.items():
        given = len(getattr(batch, name))
        _require(given in expected, f"{name} of size {given}", sorted(expected))


def check_states(
    page: states_pb2.SaveStatesResponse, request: states_pb2.SaveStatesRequest, count_before: int
) -> None:
    """Checks a page of snapshots, after `count_before` snapshots on earlier pages."""
    environments = request.environments or range(_ENV_COUNT_MAX)
    count = count_before + len(page.states)
    given = [state.environment for state in page.states]
    is_last = not page.next_page_token
    _require(
        bool(given)
        and given == list(environments[count_before:count])
        and (is_last == (count == len(environments)) or (is_last and not request.environments)),
        f"states of environments {given} after {count_before} states, last: {is_last}",
        f"{len(environments)} states, in the order of the request",
    )
    for state in page.states:
        size = len(state.snapshot)
        _require(1 <= size <= _SNAPSHOT_BYTES_MAX, f"{size} bytes", f"1 to {_SNAPSHOT_BYTES_MAX}")


def checked(method: str, serialised: bytes, response: bytes) -> bytes:
    """Returns the response to a unary call, checked as far as its method is known here."""
    if method == "CreatePool":
        pool = parse(pools_pb2.Pool, response, method)
        check_pool(pool)
        given = pool.spec.env_count
        expected = pools_pb2.CreatePoolRequest.FromString(serialised).spec.env_count
        _require(given == expected, f"{given} environments", expected)
    elif method == "GetPool":
        check_pool(parse(pools_pb2.Pool, response, method))
    elif method == "RenderEnvironments":
        request = render_pb2.RenderEnvironmentsRequest.FromString(serialised)
        _check_frames(parse(render_pb2.RenderEnvironmentsResponse, response, method), request)
    elif method == "GetEpisode":
        given = parse(states_pb2.Episode, response, method).environment
        expected = states_pb2.GetEpisodeRequest.FromString(serialised).environment
        _require(given == expected, f"an episode of environment {given}", expected)
    return response


def _check_frames(
    response: render_pb2.RenderEnvironmentsResponse, request: render_pb2.RenderEnvironmentsRequest
) -> None:
    environments = [frame.environment for frame in response.frames]
    _require(
        environments == list(request.environments),
        f"frames of environments {environments}",
        list(request.environments),
    )
    for frame in response.frames:
        given = f"a frame of {frame.size_px} x {frame.size_px} pixels in {len(frame.image)} bytes"
        size = request.size_px or frame.size_px
        expected = f"{size} x {size} pixels, 3 bytes each"
        _require(frame.size_px == size and 1 <= size <= _FRAME_SIZE_PX_MAX, given, expected)
        if request.format != render_pb2.FRAME_FORMAT_PNG:
            _require(len(frame.image) == 3 * size**2, given, expected)
