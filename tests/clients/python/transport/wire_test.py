"""The quick reader of responses gives what the generated messages give."""

from __future__ import annotations

import grpc
import numpy as np
import pytest
from google.protobuf.message import DecodeError

from procgen_client import Client, ServerProcess
from procgen_client._proto import step_pb2
from procgen_client._transport.wire import Part, part_of, read_response


def small_batch(**fields: object) -> bytes:
    batch = step_pb2.Batch(
        first_env=300,
        env_count=2,
        last=True,
        rewards=[0.5, -0.0],
        first=[True, False],
        terminated=[False, False],
        truncated=[False, True],
        level_seeds=[-1, 2**31 - 1],
        prev_level_seeds=[0, 1],
        prev_level_complete=[False, True],
        episode_returns=[1.0, 2.0],
        episode_lengths=[3, 4],
        fingerprints=[-(2**63)],
        final_observations=b"\x01" * 12288,
        observations=bytes(range(256)) * 96,
    )
    for name, value in fields.items():
        setattr(batch, name, value)
    return step_pb2.StepPoolResponse(sequence_number=2**40, batch=batch).SerializeToString()


def assert_same_part(one: Part, other: Part) -> None:
    for name in ("sequence_number", "first_env", "env_count", "last"):
        assert getattr(one, name) == getattr(other, name), name
    assert one.arrays.keys() == other.arrays.keys()
    for name, array in one.arrays.items():
        assert array.dtype == other.arrays[name].dtype, name
        np.testing.assert_array_equal(array, other.arrays[name], err_msg=name)


def slow(message: bytes) -> Part:
    return part_of(step_pb2.StepPoolResponse.FromString(message))


def test_a_batch_reads_the_same_both_ways() -> None:
    message = small_batch()
    assert_same_part(read_response(message), slow(message))


def test_pictures_are_not_copied() -> None:
    message = small_batch()
    whole = np.frombuffer(message, np.uint8)
    part = read_response(message)
    assert isinstance(part, Part)
    assert np.shares_memory(part.arrays["observations"], whole)
    assert np.shares_memory(part.arrays["final_observations"], whole)


def test_batches_of_a_real_server_read_the_same_both_ways(
    server: ServerProcess, client: Client
) -> None:
    with client.create_pool("miner", 5) as pool, grpc.insecure_channel(server.address) as channel:
        raw = channel.stream_stream(
            "/procgen.v1.StepService/StepPool",
            request_serializer=step_pb2.StepPoolRequest.SerializeToString,
            response_deserializer=bytes,
        )
        step = step_pb2.Step(actions=[-1, 0, 4, 7, -1], with_final_observations=True)
        requests = [
            step_pb2.StepPoolRequest(attach=step_pb2.Attach(pool=pool.name)),
            step_pb2.StepPoolRequest(sequence_number=1, observe=step_pb2.Observe()),
            step_pb2.StepPoolRequest(sequence_number=2, step=step),
        ]
        attached, *batches = raw(iter(requests))
    assert read_response(attached).WhichOneof("response") == "attached"
    assert len(batches) == 2
    for message in batches:
        assert_same_part(read_response(message), slow(message))


def test_fields_in_pieces_and_unpacked_are_read_too() -> None:
    # Protocol Buffers: a message field that comes twice is merged, and parsers accept repeated
    # numbers packed or not. Number 5 with wire type 5 is one float of rewards.
    response = step_pb2.StepPoolResponse(sequence_number=1)
    head = response.SerializeToString()
    first = step_pb2.Batch(env_count=2, last=True, rewards=[1.5]).SerializeToString()
    second = bytes([5 << 3 | 5]) + np.float32(2.5).tobytes()
    tag = bytes([4 << 3 | 2])
    for message in (
        head + tag + bytes([len(first)]) + first + tag + bytes([len(second)]) + second,
        head + tag + bytes([len(first) + len(second)]) + first + second,
    ):
        part = read_response(message)
        assert_same_part(part, slow(message))
        assert part.arrays["rewards"].tolist() == [1.5, 2.5]


def test_fields_of_a_later_server_are_passed_over() -> None:
    later = bytes([0xF8, 0x07, 0x01]) + bytes([0xFA, 0x07, 0x03]) + b"abc"  # Numbers 127: 1, "abc".
    batch = step_pb2.Batch(env_count=1, last=True, rewards=[3.0]).SerializeToString()
    message = bytes([4 << 3 | 2, len(batch) + len(later)]) + later + batch
    part = read_response(message)
    assert part.arrays["rewards"].tolist() == [3.0]


def test_other_answers_are_messages() -> None:
    message = step_pb2.StepPoolResponse(sequence_number=7, ack=step_pb2.Ack())
    assert read_response(message.SerializeToString()) == message


@pytest.mark.parametrize(
    "garbage", [b"\xff", b"\x22\xff\xff\xff\xff\x7f", b"\x22\x05\x01", b"\x07"]
)
def test_garbage_is_an_error(garbage: bytes) -> None:
    with pytest.raises(DecodeError):
        read_response(garbage)


def test_a_batch_cut_short_anywhere_is_an_error_or_a_shorter_one() -> None:
    message = small_batch(observations=b"", final_observations=b"")
    for end in range(1, len(message)):
        try:
            expected = step_pb2.StepPoolResponse.FromString(message[:end])
        except DecodeError:
            with pytest.raises(DecodeError):
                read_response(message[:end])
        else:
            assert read_response(message[:end]) == expected
