"""The script of the wire fixtures: the requests, the paths and the expected values."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterator
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
sys.path.append(str(FOLDER.parent / "python"))

from procgen_client._proto import pools_pb2, step_pb2  # noqa: E402
from procgen_client._transport import grpc_fallback  # noqa: E402
from procgen_client.batch import Batch, batch_of  # noqa: E402

# Folder of messages: encoding.
ENCODINGS = {
    "raw": pools_pb2.ENCODING_RAW,
    "zstd": pools_pb2.ENCODING_DELTA_ZSTD,
}
CATALOG = "catalog.response.bin"
EXPECTED = "expected.json"
_SIZE_PX = 16


def create_pool_request(encoding: str) -> pools_pb2.CreatePoolRequest:
    """Two grayscale environments without art: small messages that do not depend on the art."""
    return pools_pb2.CreatePoolRequest(
        pool_id="recorded",
        spec=pools_pb2.PoolSpec(
            games=["maze"],
            env_count=2,
            options=pools_pb2.EnvironmentOptions(
                distribution_mode=pools_pb2.DISTRIBUTION_MODE_EASY,
                rand_seed=5,
                use_monochrome_assets=True,
            ),
            observation_format=pools_pb2.ObservationFormat(
                color=pools_pb2.COLOR_GRAYSCALE, size_px=_SIZE_PX
            ),
            encoding=ENCODINGS[encoding],
        ),
    )


def requests() -> list[step_pb2.StepPoolRequest]:
    """All requests of the stream, in order; the first attaches."""
    reset = step_pb2.Reset
    asked = [
        {"attach": step_pb2.Attach(pool="pools/recorded")},
        {"observe": step_pb2.Observe()},
        {"step": step_pb2.Step(actions=[4, 7], chunk_count=2)},
        {"step": step_pb2.Step(actions=[-1, 3], with_final_observations=True)},
        {
            "step": step_pb2.Step(
                slice=step_pb2.Slice(first_env=1, env_count=1),
                actions=[8],
                repeat_count=3,
                next_levels=[step_pb2.NextLevel(environment=1, level_seed=42)],
            )
        },
        {
            "step": step_pb2.Step(
                actions=[4, 4],
                observation=step_pb2.OBSERVATION_NONE,
                resets=[reset(environment=1)],
            )
        },
        {
            "reset": step_pb2.ResetSlice(
                resets=[reset(environment=0, level_seed=7, rand_seed=9)]
            )
        },
        {
            "level_sampler": pools_pb2.LevelSampler(
                level_seeds=[3, 5], weights=[1, 2], rand_seed=1
            )
        },
        {"reset": step_pb2.ResetSlice(resets=[reset(environment=0), reset(environment=1)])},
        {"step": step_pb2.Step(actions=[2, 6])},
    ]
    return [
        step_pb2.StepPoolRequest(sequence_number=number, **what)
        for number, what in enumerate(asked)
    ]


def response_paths(encoding: str, number: int) -> list[Path]:
    """Returns the files with the responses to a sequence number, in order; 0: attach."""
    return sorted((FOLDER / encoding).glob(f"{number}.response-*.bin"))


def expected_values(
    responses: list[list[step_pb2.StepPoolResponse]],
) -> Iterator[dict[str, object] | None]:
    """What a client should make of the raw responses to each request; None: no values."""
    shape = tuple(responses[0][0].attached.pool.observation_shape)
    for answer in responses:
        parts = [response for response in answer if response.HasField("batch")]
        yield values_of(batch_of(grpc_fallback.Batch(parts, shape), owned=True)) if parts else None


def values_of(batch: Batch) -> dict[str, object]:
    """The values of a batch as they stand in EXPECTED."""
    values: dict[str, object] = {
        name: getattr(batch, name).tolist()
        for name in (
            "rewards", "first", "terminated", "truncated", "level_seeds", "prev_level_seeds",
            "prev_level_complete", "episode_returns", "episode_lengths",
        )
    }  # fmt: skip
    values["first_env"] = batch.first_env
    # As text, because JSON numbers have 53 bits in some languages.
    values["fingerprints"] = [str(hash_) for hash_ in batch.fingerprints]
    for name in ("final_observations", "observations"):
        array = getattr(batch, name)
        content = b"" if array is None else array.tobytes()
        values[name] = {"bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}
    return values
