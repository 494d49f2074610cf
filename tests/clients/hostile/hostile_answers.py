"""Responses of a faulty or hostile server: changes to real responses, by mode."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from procgen_client._proto import pools_pb2, render_pb2, states_pb2, step_pb2

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
# Bytes that are no valid message: a length of 4 GiB, a varint of eleven bytes, an unknown wire
# type.
_LYING_BYTES = {
    "length_beyond_the_end": b"\x08\x03\x22\xff\xff\xff\xff\x0f\x08\x00",
    "varint_without_end": b"\x08" + b"\xff" * 20,
    "wire_type_that_is_none": b"\x08\x03\x27\x00",
    "array_of_half_an_element": b"\x08\x03\x22\x05\x2a\x03\x00\x00\x00",
    "no_protobuf": bytes(range(255, 0, -1)) * 40,
}

Batch = step_pb2.Batch


def _set(name: str, value: object) -> Callable[[Batch], None]:
    return lambda batch: setattr(batch, name, value)


def _resize(name: str, count: int) -> Callable[[Batch], None]:
    def change(batch: Batch) -> None:
        values = (list(getattr(batch, name)) * 3 or [0] * 64)[:count]
        del getattr(batch, name)[:]
        getattr(batch, name).extend(values)

    return change


def _short_rows(batch: Batch) -> None:
    for name in _ROWS:
        _resize(name, 1)(batch)


def _all_ended(batch: Batch) -> None:
    batch.terminated[:] = [True] * len(batch.terminated)
    batch.fingerprints[:] = [7]


# Changes to the batch in the response to a step.
BATCHES: dict[str, Callable[[Batch], None]] = {
    **{f"no_{name}": _resize(name, 0) for name in _ROWS},
    **{f"more_{name}": _resize(name, 9) for name in _ROWS},
    "one_row": _short_rows,
    "few_fingerprints": _all_ended,
    "observations_cut": _set("observations", b"\1" * 10),
    "observations_none": _set("observations", b""),
    "observations_more": lambda batch: _set("observations", batch.observations + b"x")(batch),
    "final_observations_cut": _set("final_observations", b"\1" * 10),
    "first_env_large": _set("first_env", 2**30),
    "first_env_negative": _set("first_env", -(2**30)),
    "count_zero": _set("env_count", 0),
    "count_negative": _set("env_count", -1),
    "count_large": _set("env_count", 2**31 - 1),
    "never_last": _set("last", False),
    "shared_batch": _set("shared_batch", 3),
}


def _fewer(attached: step_pb2.Attached) -> None:
    attached.pool.spec.env_count = 1


def _unlike(name: str, value: object) -> Callable[[step_pb2.Attached], None]:
    return lambda attached: setattr(attached.pool, name, value)


# Changes to the response to attach.
ATTACHED: dict[str, Callable[[step_pb2.Attached], None]] = {
    "attached_without_a_pool": lambda attached: attached.ClearField("pool"),
    "attached_to_another_pool": _unlike("name", "pools/another"),
    "attached_to_many_environments": lambda a: setattr(a.pool.spec, "env_count", 2**31 - 1),
    "attached_to_no_environments": lambda a: setattr(a.pool.spec, "env_count", 0),
    "attached_with_small_observations": _unlike("observation_bytes", 1),
    "attached_with_huge_shape": lambda a: a.pool.observation_shape.extend([2**31 - 1] * 3),
    "attached_without_shape": lambda a: a.pool.ClearField("observation_shape"),
    "attached_in_flight_none": lambda a: setattr(a, "requests_in_flight_max", -1),
    "attached_at_a_negative_number": lambda a: setattr(a, "next_sequence_number", -5),
    "attached_to_shared_memory": lambda a: setattr(a.shared_memory, "path", "/dev/zero"),
}

StreamAnswer = step_pb2.StepPoolResponse


def stream_answers(mode: str, message: bytes) -> Iterator[bytes]:
    """Yields the messages that replace a StepPoolResponse."""
    response = StreamAnswer.FromString(message)
    number = response.sequence_number
    is_step = response.HasField("batch") and number >= 3
    if response.HasField("attached") and mode in ATTACHED:
        ATTACHED[mode](response.attached)
    elif response.HasField("attached") and mode == "attached_missing":
        response = StreamAnswer(ack=step_pb2.Ack())
    elif is_step and mode in BATCHES:
        BATCHES[mode](response.batch)
    elif is_step and mode in _LYING_BYTES:
        yield _LYING_BYTES[mode]
        return
    elif is_step and mode == "answers_without_end":
        response.batch.last = False
        while True:
            yield response.SerializeToString()
    elif is_step and mode == "notices_without_end":
        while True:
            yield b""
    elif is_step:
        yield from _other_answers(mode, response)
        return
    yield response.SerializeToString()


def _other_answers(mode: str, response: StreamAnswer) -> Iterator[bytes]:
    number = response.sequence_number
    if mode == "done_in_place_of_values":
        response = StreamAnswer(sequence_number=number, ack=step_pb2.Ack())
    elif mode == "attached_again":
        response = StreamAnswer(sequence_number=number, attached=step_pb2.Attached())
    elif mode == "answer_of_unknown_kind":
        response = StreamAnswer(sequence_number=number)
    elif mode == "number_before":
        response.sequence_number -= 1
    elif mode == "number_after":
        response.sequence_number += 1
    elif mode == "number_negative":
        response.sequence_number = -(2**62)
    elif mode == "notice_before":
        yield b"\xfa\x07\x03new"  # Field 127, of a later server.
    elif mode == "answered_twice":
        yield response.SerializeToString()
    elif mode == "frame_that_is_none":
        response.batch.observations = b"\x28\xb5\x2f\xfd" + b"\xff" * 40
    elif mode == "frame_that_says_it_is_huge":
        # zstd: a frame with a content size of 2^40 bytes.
        size = (2**40).to_bytes(8, "little")
        response.batch.observations = b"\x28\xb5\x2f\xfd\xe0" + size + b"\1"
    elif mode == "frame_of_zeros":
        # zstd: a block that repeats one byte 128 Ki times.
        size = (131072).to_bytes(4, "little")
        response.batch.observations = b"\x28\xb5\x2f\xfd\xa0" + size + b"\x03\x00\x10\x00"
    elif mode == "frame_cut":
        response.batch.observations = response.batch.observations[:-3]
    yield response.SerializeToString()


STREAM_ERRORS = [
    *BATCHES,
    *ATTACHED,
    *_LYING_BYTES,
    "attached_missing",
    "answers_without_end",
    "notices_without_end",
    "done_in_place_of_values",
    "attached_again",
    "answer_of_unknown_kind",
    "number_before",
    "number_after",
    "number_negative",
    "answered_twice",
]
ENCODED_ERRORS = [
    "frame_that_is_none",
    "frame_that_says_it_is_huge",
    "frame_of_zeros",
    "frame_cut",
    "observations_none",
    "attached_to_many_environments",
]
# From later servers: clients continue.
STREAM_HARMLESS = ["undisturbed", "notice_before"]


def _pages_of_states(page: states_pb2.SaveStatesResponse) -> None:
    page.next_page_token = "again"


def _large_snapshot(page: states_pb2.SaveStatesResponse) -> None:
    page.states[0].snapshot = bytes(2**20 + 1)


def _frame(name: str, value: object) -> Callable[[render_pb2.RenderEnvironmentsResponse], None]:
    return lambda rendered: setattr(rendered.frames[0], name, value)


def _shape(pool: pools_pb2.Pool) -> None:
    pool.observation_shape[:] = [2**31 - 1] * 4


_STATES, _FRAMES = states_pb2.SaveStatesResponse, render_pb2.RenderEnvironmentsResponse
# Changes to the responses of unary calls: method, type, change.
UNARY: dict[str, tuple[str, type, Callable]] = {
    "states_none": ("SaveStates", _STATES, lambda page: page.ClearField("states")),
    "states_fewer": ("SaveStates", _STATES, lambda page: page.states.pop()),
    "states_of_others": ("SaveStates", _STATES, lambda page: page.states.reverse()),
    "states_without_end": ("SaveStates", _STATES, _pages_of_states),
    "states_huge": ("SaveStates", _STATES, _large_snapshot),
    "frames_none": ("RenderEnvironments", _FRAMES, lambda r: r.ClearField("frames")),
    "frames_of_others": ("RenderEnvironments", _FRAMES, _frame("environment", 5)),
    "frames_cut": ("RenderEnvironments", _FRAMES, _frame("image", b"\1" * 10)),
    "frames_wide": ("RenderEnvironments", _FRAMES, _frame("size_px", 2**31 - 1)),
    "frames_negative": ("RenderEnvironments", _FRAMES, _frame("size_px", -64)),
    "pools_without_end": (
        "ListPools",
        pools_pb2.ListPoolsResponse,
        lambda page: setattr(page, "next_page_token", "again"),
    ),
    "pool_without_spec": ("CreatePool", pools_pb2.Pool, lambda pool: pool.ClearField("spec")),
    "pool_without_name": ("CreatePool", pools_pb2.Pool, lambda pool: pool.ClearField("name")),
    "pool_of_others": (
        "CreatePool",
        pools_pb2.Pool,
        lambda pool: setattr(pool.spec, "env_count", 2**31 - 1),
    ),
    "pool_of_huge_shape": ("CreatePool", pools_pb2.Pool, _shape),
    "episode_of_another": (
        "GetEpisode",
        states_pb2.Episode,
        lambda episode: setattr(episode, "environment", 3),
    ),
}


def unary_answer(mode: str, method: str, message: bytes) -> bytes:
    """Returns the replacement of a unary response."""
    if mode == "unary_no_protobuf" and method != "GetCatalog":
        return _LYING_BYTES["no_protobuf"]
    if mode == "catalog_empty" and method == "GetCatalog":
        return b""
    if mode in UNARY and method == UNARY[mode][0]:
        response = UNARY[mode][1].FromString(message)
        UNARY[mode][2](response)
        return response.SerializeToString()
    return message


UNARY_ERRORS = [*UNARY, "unary_no_protobuf"]
