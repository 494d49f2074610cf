"""What is read of a shared memory, and what is refused, without a server."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

from procgen_client import Batch, errors
from procgen_client._proto import pools_pb2, step_pb2
from procgen_client._requests import Request
from procgen_client._transport.shared_memory import SharedMapping
from procgen_client._transport.wire import ARRAY_TYPES, PICTURES
from procgen_client._validation import Expected

_ENV_COUNT = 48
_BATCH_COUNT = 2
_BATCH_BYTES = 8192
_ELEMENT_TYPES = {
    "rewards": step_pb2.ELEMENT_TYPE_FLOAT32,
    "first": step_pb2.ELEMENT_TYPE_BOOL,
    "terminated": step_pb2.ELEMENT_TYPE_BOOL,
    "truncated": step_pb2.ELEMENT_TYPE_BOOL,
    "level_seeds": step_pb2.ELEMENT_TYPE_INT32,
    "prev_level_seeds": step_pb2.ELEMENT_TYPE_INT32,
    "prev_level_complete": step_pb2.ELEMENT_TYPE_BOOL,
    "episode_returns": step_pb2.ELEMENT_TYPE_FLOAT32,
    "episode_lengths": step_pb2.ELEMENT_TYPE_INT32,
    "fingerprints": step_pb2.ELEMENT_TYPE_INT64,
    "final_observations": step_pb2.ELEMENT_TYPE_UINT8,
    "observations": step_pb2.ELEMENT_TYPE_UINT8,
}


def _told(path: str = "/nowhere", **changes: object) -> step_pb2.SharedMemory:
    """Of 48 environments with two bytes of observation, told as it should be."""
    arrays = [
        step_pb2.SharedArray(
            field=name,
            offset_bytes=512 * i,
            element_type=kind,
            shape=[_ENV_COUNT, 2] if name in PICTURES else [_ENV_COUNT],
        )
        for i, (name, kind) in enumerate(_ELEMENT_TYPES.items())
    ]
    told = {"path": path, "batch_count": _BATCH_COUNT, "batch_bytes": _BATCH_BYTES}
    told |= {"size_bytes": _BATCH_COUNT * _BATCH_BYTES, "arrays": arrays}
    return step_pb2.SharedMemory(**(told | changes))


def _pool() -> pools_pb2.Pool:
    spec = pools_pb2.PoolSpec(env_count=_ENV_COUNT)
    return pools_pb2.Pool(spec=spec, observation_shape=[2], observation_bytes=2)


@pytest.fixture
def content() -> list[dict[str, np.ndarray]]:
    """What stands in the arrays of each batch: a third of the episodes has ended in each way."""
    random = np.random.default_rng(0)
    batches = []
    for _ in range(_BATCH_COUNT):
        batch = {
            name: random.integers(0, 100, _ENV_COUNT).astype(dtype)
            for name, dtype in ARRAY_TYPES.items()
        }
        ends = random.integers(0, 3, _ENV_COUNT)
        batch |= {"terminated": ends == 1, "truncated": ends == 2}
        batch |= {name: random.integers(0, 256, (_ENV_COUNT, 2), np.uint8) for name in PICTURES}
        batches.append(batch)
    return batches


@pytest.fixture
def mapping(tmp_path: Path, content: list[dict[str, np.ndarray]]) -> SharedMapping:
    """A mapping of a file with that content."""
    file = tmp_path / "shared"
    told = _told(str(file))
    memory = bytearray(told.size_bytes)
    for number, batch in enumerate(content):
        for array in told.arrays:
            begin = number * _BATCH_BYTES + array.offset_bytes
            values = batch[array.field].tobytes()
            memory[begin : begin + len(values)] = values
    file.write_bytes(memory)
    return SharedMapping(told, _pool())


def _request(number: int = 300, **fields: object) -> Request:
    """What the answer with these fields is right for."""
    first = fields.get("first_env", 0)
    count = fields.get("env_count", _ENV_COUNT)
    pictures = fields.get("shared_observations", False)
    finals = fields.get("shared_final_observations", False)
    return Request.numbered(number, b"", Expected(first, count, pictures, finals))


def _answer(number: int = 300, **fields: object) -> step_pb2.StepPoolResponse:
    batch = {"env_count": _ENV_COUNT, "last": True, "shared_batch": 0}
    return step_pb2.StepPoolResponse(
        sequence_number=number, batch=step_pb2.Batch(**(batch | fields))
    )


def _read(mapping: SharedMapping, **fields: object) -> Batch:
    batch = mapping.read(_answer(**fields).SerializeToString(), _request(**fields))
    assert batch is not None
    return batch


def test_each_slice_of_each_batch_is_read_where_it_is(
    mapping: SharedMapping, content: list[dict[str, np.ndarray]]
) -> None:
    # More slices than the mapping knows at a time.
    slices = [(a, b) for a in range(_ENV_COUNT) for b in range(a + 1, _ENV_COUNT + 1)]
    for number, (begin, end) in [(k, rows) for rows in slices for k in range(_BATCH_COUNT)]:
        fields = {"first_env": begin, "env_count": end - begin}
        fields |= {"shared_batch": number, "shared_observations": True}
        batch = _read(mapping, **fields, shared_final_observations=begin % 2 == 0)
        expected = {name: array[begin:end] for name, array in content[number].items()}
        ended = np.count_nonzero(expected["terminated"] | expected["truncated"])
        expected["fingerprints"] = expected["fingerprints"][:ended]
        expected["final_observations"] = expected["final_observations"][: ended * (begin % 2 == 0)]
        assert (batch.sequence_number, batch.first_env) == (300, begin)
        for name, values in expected.items():
            array = getattr(batch, name)
            assert array.dtype == values.dtype, name
            assert array.flags.aligned, name
            assert array.flags.writeable is (name not in PICTURES) or not array.size, name
            np.testing.assert_array_equal(array, values, name)


def test_numbers_are_those_of_the_answer_whenever_they_are_asked_for(
    mapping: SharedMapping, content: list[dict[str, np.ndarray]]
) -> None:
    batch = _read(mapping, shared_observations=True)
    again = pickle.loads(pickle.dumps(batch))
    Path(mapping.path).write_bytes(bytes(_BATCH_COUNT * _BATCH_BYTES))  # The server goes on.
    for read in (batch, again):
        np.testing.assert_array_equal(read.rewards, content[0]["rewards"])
        ended = content[0]["terminated"] | content[0]["truncated"]
        np.testing.assert_array_equal(read.ended, ended)
        assert read.level_seeds is read.level_seeds, "who writes to it finds what was written"
        assert "rewards=array(" in repr(read)
        with pytest.raises(AttributeError, match="a batch has no reward"):
            read.reward  # noqa: B018 - a misspelt name
    np.testing.assert_array_equal(again.observations, content[0]["observations"])


def test_fields_of_a_batch_stand_as_its_arrays_do() -> None:
    names = ["sequence_number", "first_env", *ARRAY_TYPES, *PICTURES]
    assert list(Batch.__dataclass_fields__) == names


def test_an_answer_is_read_whatever_the_order_of_its_fields(mapping: SharedMapping) -> None:
    whole = _answer().SerializeToString()
    batch = _answer(0).SerializeToString()
    for number in (300, 301):  # The second one is not taken for the first.
        request = _request(number)
        for message in (request.head + batch, batch + request.head):
            read = mapping.read(message, request)
            assert read is not None
            assert read.sequence_number == number
    assert mapping.read(whole, _request(300)) is not None


def test_what_answers_otherwise_is_not_read(mapping: SharedMapping) -> None:
    head, batch = _request().head, _answer(0).SerializeToString()
    for message in (head + batch, batch + head):  # It knows such an answer.
        assert mapping.read(message, _request()) is not None
    ack = step_pb2.StepPoolResponse(sequence_number=300, ack=step_pb2.Ack())
    for message in (
        _answer(301).SerializeToString(),
        _answer(0).SerializeToString(),
        ack.SerializeToString(),
        head,
        b"",
        b"\xff",
    ):
        assert mapping.read(message, _request()) is None


@pytest.mark.parametrize(
    "fields",
    [
        {"shared_batch": _BATCH_COUNT},
        {"shared_batch": -1},
        {"first_env": -1},
        {"first_env": 1},
        {"env_count": 0},
        {"env_count": _ENV_COUNT + 1},
    ],
)
def test_what_is_not_there_is_refused(mapping: SharedMapping, fields: dict[str, int]) -> None:
    with pytest.raises(errors.InternalError, match="which there are not"):
        _read(mapping, **fields)


@pytest.mark.parametrize(
    "fields",
    [
        {"first_env": 1, "env_count": 2},
        {"env_count": 1},
        {"shared_observations": True},
        {"shared_final_observations": True},
    ],
)
def test_what_was_not_asked_for_is_refused(
    mapping: SharedMapping, fields: dict[str, int]
) -> None:
    with pytest.raises(errors.InternalError, match="expected: one that is not held, with"):
        mapping.read(_answer(**fields).SerializeToString(), _request())


def test_a_batch_that_is_held_is_not_answered_again(mapping: SharedMapping) -> None:
    held = _read(mapping, shared_observations=True)
    with pytest.raises(errors.InternalError, match="expected: one that is not held"):
        _read(mapping, shared_observations=True)
    del held
    _read(mapping, shared_observations=True)


def test_a_batch_is_held_by_its_pictures_only(mapping: SharedMapping) -> None:
    numbers = _read(mapping)
    assert numbers.observations is None
    assert mapping.held_count == 0
    batch = _read(mapping, shared_observations=True, shared_final_observations=True)
    mapping.take_released()
    assert mapping.take_held() == [0]
    parts = [batch.observations[3:, 1], batch.final_observations.T]
    del batch
    while parts:
        assert mapping.held_count == 1
        parts.pop()
    assert mapping.held_count == 0
    told = step_pb2.StepPoolRequest.FromString(mapping.take_released())
    assert list(told.released_batches) == [0]
    assert mapping.take_released() == b""


def test_batches_that_are_released_together_are_told_together(mapping: SharedMapping) -> None:
    for number in range(_BATCH_COUNT):
        _read(mapping, shared_batch=number)
    told = step_pb2.StepPoolRequest.FromString(mapping.take_released())
    assert list(told.released_batches) == list(range(_BATCH_COUNT))


def test_memory_that_is_told_wrongly_is_refused() -> None:
    with pytest.raises(errors.FailedPreconditionError, match="/nowhere"):
        SharedMapping(_told(), _pool())
    for changes in (
        {"batch_count": 3},
        {"batch_count": 0},
        {"arrays": []},
        {"size_bytes": 64 * _BATCH_COUNT, "batch_bytes": 64},
    ):
        with pytest.raises(errors.InternalError):
            SharedMapping(_told(**changes), _pool())
    for field, value in (("offset_bytes", -64), ("offset_bytes", 8192), ("element_type", 1)):
        memory = _told()
        setattr(memory.arrays[0], field, value)
        with pytest.raises(errors.InternalError, match="rewards"):
            SharedMapping(memory, _pool())
    memory = _told()
    memory.arrays[0].shape[:] = [_ENV_COUNT - 1]
    with pytest.raises(errors.InternalError):
        SharedMapping(memory, _pool())
