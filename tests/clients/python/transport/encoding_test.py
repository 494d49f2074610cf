"""What a server's encoder writes is decoded to what it was given, to the last bit."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from procgen_client._proto import pools_pb2
from procgen_client._transport import encoding
from procgen_client._transport.encoding import ObservationDecoder
from procgen_client.errors import (
    DataLossError,
    FailedPreconditionError,
    InvalidArgumentError,
    UnimplementedError,
)

_GAMES = (
    "bigfish bossfight caveflyer chaser climber coinrun dodgeball fruitbot "
    "heist jumper leaper maze miner ninja plunder starpilot"
).split()
# Colours, layout, side, stack.
_FORMATS = (
    "rgb hwc 64 1",
    "rgb chw 64 1",
    "grey hwc 84 1",
    "rgb hwc 43 1",
    "grey chw 44 4",
    "rgb chw 20 3",
)


def rollout_program() -> Path:
    """What CTest says, else what was built last in this checkout."""
    if "PROCGEN_ENCODED_ROLLOUT" in os.environ:
        return Path(os.environ["PROCGEN_ENCODED_ROLLOUT"])
    built = list(Path(__file__).resolve().parents[4].glob("build/*/bin/encoded_rollout"))
    if not built:
        pytest.exit("no encoded_rollout was built", returncode=2)
    return max(built, key=lambda path: path.stat().st_mtime)


class Rollout:
    """What encoded_rollout writes: the pool, and answers as (first, count, encoded, raw)."""

    def __init__(self, game: str, form: str, count: int) -> None:
        command = [rollout_program(), game, *form.split(), str(count)]
        self._bytes = subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout
        self._position = 0
        self.pool = pools_pb2.Pool.FromString(self._take(self._number()))

    def answers(self, observation_bytes: int) -> Iterator[tuple[int, int, bytes, bytes]]:
        while self._position < len(self._bytes):
            first, count = self._number(), self._number()
            encoded = self._take(self._number())
            yield first, count, encoded, self._take(count * observation_bytes)

    def _number(self) -> int:
        return int.from_bytes(self._take(4), "little")

    def _take(self, count: int) -> bytes:
        self._position += count
        return self._bytes[self._position - count : self._position]


# Each game with default observations; each form of observation in two games, of which one scrolls.
_PLAYS = [(game, _FORMATS[0]) for game in _GAMES] + [
    (game, form) for form in _FORMATS[1:] for game in ("coinrun", "starpilot")
]


@pytest.mark.parametrize("game,form", _PLAYS)
def test_decoded_is_what_was_encoded(game: str, form: str) -> None:
    rollout = Rollout(game, form, 100)
    decoder = ObservationDecoder(rollout.pool)
    answer_count = 0
    for first, count, encoded, raw in rollout.answers(decoder.observation_bytes):
        decoded = decoder.decode(first, count, encoded)
        assert decoded.tobytes() == raw, f"answer {answer_count}"
        answer_count += 1
    assert answer_count == 100


def test_damaged_bytes_are_refused_or_change_nothing() -> None:
    rollout = Rollout("coinrun", "rgb hwc 64 1", 12)
    decoder = ObservationDecoder(rollout.pool)
    refused = 0
    for first, count, encoded, raw in rollout.answers(decoder.observation_bytes):
        for i in range(0, len(encoded), 1 + len(encoded) // 50):
            flipped = bytearray(encoded)
            flipped[i] ^= 1 << i % 8
            fresh = ObservationDecoder(rollout.pool)
            fresh._ages[:], fresh._shown[:] = decoder._ages, decoder._shown
            try:
                assert fresh.decode(first, count, bytes(flipped)).tobytes() == raw
            except DataLossError:
                refused += 1
            with pytest.raises(DataLossError):
                decoder.decode(first, count, encoded[:i])
        assert decoder.decode(first, count, encoded).tobytes() == raw
    assert refused > 100


def test_answers_that_are_missing_or_come_twice_are_found() -> None:
    rollout = Rollout("maze", "rgb hwc 64 1", 40)
    decoder = ObservationDecoder(rollout.pool)
    answers = list(rollout.answers(decoder.observation_bytes))
    # By then each environment was seen; the first time has no past, and may come again.
    for first, count, encoded, _ in answers[:20]:
        decoder.decode(first, count, encoded)
    for first, count, encoded, _ in answers[20:-1]:
        decoder.decode(first, count, encoded)
        with pytest.raises(FailedPreconditionError, match="came twice"):
            decoder.decode(first, count, encoded)
    first, count, encoded, _ = answers[-1]
    with pytest.raises(FailedPreconditionError, match="missing"):
        ObservationDecoder(rollout.pool).decode(first, count, encoded)


def test_noise_is_refused() -> None:
    rollout = Rollout("maze", "rgb hwc 64 1", 1)
    decoder = ObservationDecoder(rollout.pool)
    noise = np.random.default_rng(1)
    for size in (0, 1, 4, 20, 1000):
        with pytest.raises(DataLossError):
            decoder.decode(0, 1, noise.integers(0, 256, size, np.uint8).tobytes())


@pytest.mark.parametrize("first,count", [(-1, 2), (0, 0), (2, 3), (4, 1)])
def test_environments_that_the_pool_has_not_are_refused(first: int, count: int) -> None:
    rollout = Rollout("maze", "rgb hwc 64 1", 1)
    with pytest.raises(InvalidArgumentError, match="the pool has 4"):
        ObservationDecoder(rollout.pool).decode(first, count, b"")


def test_other_encodings_are_refused() -> None:
    with pytest.raises(InvalidArgumentError, match="encoding is 1"):
        ObservationDecoder(pools_pb2.Pool(spec={"encoding": pools_pb2.ENCODING_RAW}))


def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "zstandard", None)
    with pytest.raises(UnimplementedError, match="python3-zstandard"):
        encoding.check_decodable(pools_pb2.ENCODING_DELTA_ZSTD)
