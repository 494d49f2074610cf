"""Decodes observations that a server sends compressed (``PoolSpec.encoding``).

The comment of ``Encoding`` in ``procgen/v1/pools.proto`` defines the bytes. Nothing here loops over
environments, blocks or pixels: a slice is decoded by a few operations on whole arrays.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from procgen_client._proto import pools_pb2
from procgen_client._transport.wire import Part
from procgen_client.errors import (
    DataLossError,
    FailedPreconditionError,
    InvalidArgumentError,
    ProcgenError,
    UnimplementedError,
)

_SIDE = 8  # of a block, in rows and pixels


def _damaged(what: str) -> DataLossError:
    return DataLossError(f"encoded observations: {what}")


def _module(name: str, package: str) -> Any:  # noqa: ANN401 - a module
    try:
        return __import__(name, fromlist=["_"])
    except ImportError as error:
        raise UnimplementedError(
            f"this encoding needs the Python package {name.split('.')[0]!r}, which is not "
            f"installed (on Debian: apt install {package})"
        ) from error


class _Zstd:
    """Content of one zstd frame."""

    def __init__(self) -> None:
        self._zstd = _module("zstandard", "python3-zstandard")
        self._decompressor = self._zstd.ZstdDecompressor()

    def content(self, frame: bytes, size_max: int) -> bytes:
        try:
            size = self._zstd.frame_content_size(frame)
            if not 0 <= size <= size_max:
                raise _damaged(f"content of {size} bytes, there can be {size_max} at most")
            # Takes the memory that the header tells, and no more.
            return self._decompressor.decompress(frame)
        except self._zstd.ZstdError as error:
            raise _damaged(f"not one whole frame of zstd: {error}") from error


def check_decodable(encoding: int) -> None:
    """Sees that observations of this encoding can be decoded here, if it is one that is known.

    Raises:
        UnimplementedError: The package that decompresses it is not installed.
    """
    if encoding == pools_pb2.ENCODING_DELTA_ZSTD:
        _Zstd()


def decoder_for(pool: pools_pb2.Pool) -> ObservationDecoder | None:
    """Gives what decodes the observations of a pool; None: they are not encoded.

    Errors as ObservationDecoder.
    """
    if pool.spec.encoding in (pools_pb2.ENCODING_UNSPECIFIED, pools_pb2.ENCODING_RAW):
        return None
    return ObservationDecoder(pool)


def decode_parts(decoder: ObservationDecoder, pool: str, parts: list[Part]) -> None:
    """Puts decoded observations in the place of encoded ones, of a whole answer of a pool.

    Raises:
        DataLossError: They are damaged; what the decoder knows is of no more use.
    """
    try:
        for part in parts:
            encoded = part.arrays["observations"]
            if len(encoded):
                part.arrays["observations"] = decoder.decode(
                    part.first_env, part.env_count, encoded.tobytes()
                )
    except ProcgenError as error:
        raise DataLossError(
            f"the answer of {pool} to request {parts[0].sequence_number}: {error.message}"
        ) from None


class _Reader:
    """Takes parts off the front of an array of bytes."""

    def __init__(self, content: bytes) -> None:
        self._left = np.frombuffer(content, np.uint8)

    def take(self, count: int) -> np.ndarray:
        """Gives the next ``count`` bytes."""
        if count > len(self._left):
            raise _damaged(f"they end {count - len(self._left)} bytes early")
        part, self._left = self._left[:count], self._left[count:]
        return part

    def end(self) -> None:
        """Sees that nothing is left."""
        if len(self._left):
            raise _damaged(f"there are {len(self._left)} bytes too many")


def _bits(values: np.ndarray) -> np.ndarray:
    """The bits of bytes, least first: uint8 [..., 8]."""
    return np.unpackbits(values[..., np.newaxis], axis=-1, bitorder="little")


@dataclass(slots=True)
class _Blocks:
    """The changed blocks of a slice, m of them: where they are, and what they show."""

    rows: np.ndarray  # of environments in the slice                       [m]
    indices: np.ndarray  # of blocks in the picture                        [m]
    moves: np.ndarray  # from how far below and to the right they come     int [2, m]
    patched: np.ndarray  # which pixels are told anew                      bool [m, 8, 8]
    pixels: np.ndarray  # these pixels                                     uint8 [p, pixel_bytes]


class ObservationDecoder:
    """Decodes the observations of one pool for one learner.

    All that its answers bear, each once, in the order of their sequence numbers, also across broken
    connections.

    After an error nothing has changed, and decoding can go on with the right bytes.
    """

    def __init__(self, pool: pools_pb2.Pool) -> None:
        """Prepares for a pool as the server told it.

        Raises:
            InvalidArgumentError: The pool's encoding is none that is decoded here.
            UnimplementedError: The package that decompresses it is not installed.
        """
        spec = pool.spec
        if spec.encoding != pools_pb2.ENCODING_DELTA_ZSTD:
            raise InvalidArgumentError(
                f"encoding is {spec.encoding}; decoded is ENCODING_DELTA_ZSTD"
            )
        self._decompressor = _Zstd()
        layout = spec.observation_format
        size_px = layout.size_px or 64
        channels = 1 if layout.color == pools_pb2.COLOR_GRAYSCALE else 3
        planes = layout.layout == pools_pb2.LAYOUT_CHW
        self._stack = max(layout.frame_stack, 1)
        self._rows = size_px * self._stack * (channels if planes else 1)
        self._columns = size_px
        self._pixel_bytes = 1 if planes else channels
        self._block_rows = -(-self._rows // _SIDE)
        self._block_columns = -(-self._columns // _SIDE)
        self._block_count = self._block_rows * self._block_columns
        # What is next; 0: only an observation without a past.
        self._ages = np.zeros(spec.env_count, np.uint8)
        self._shown = np.zeros(
            (spec.env_count, self._rows, self._columns, self._pixel_bytes), np.uint8
        )

    @property
    def observation_bytes(self) -> int:
        """Bytes of one decoded observation."""
        return self._rows * self._columns * self._pixel_bytes

    def decode(self, first: int, count: int, encoded: bytes) -> np.ndarray:
        """Decodes the observations of environments first ... first + count - 1.

        Returns:
            uint8 [count * observation_bytes], an array of the caller's own.

        Raises:
            InvalidArgumentError: The pool has no such environments.
            DataLossError: The bytes are no such observations.
            FailedPreconditionError: They follow others than were decoded last.
        """
        if not (first >= 0 and 0 < count <= len(self._ages) - first):
            raise InvalidArgumentError(
                f"environments {first} and {count} from there; the pool has {len(self._ages)}"
            )
        content = self._decompressor.content(bytes(encoded), self._content_bytes_max(count))
        reader = _Reader(content)
        ages = reader.take(count)
        advances = reader.take(count if self._stack > 1 else 0)
        self._check_environments(first, ages, advances)
        blocks = self._read_blocks(reader, count)
        basis = self._basis(first, ages, advances)
        observations = self._changed(basis, blocks) if len(blocks.rows) else basis.copy()
        self._shown[first : first + count] = observations
        self._ages[first : first + count] = np.where(ages == 255, 1, ages + 1)
        return observations.reshape(-1)

    def _content_bytes_max(self, count: int) -> int:
        numbers = 2 + -(-self._block_count // 8) + self._block_count * (3 + _SIDE)
        return count * (numbers + self.observation_bytes)

    def _check_environments(self, first: int, ages: np.ndarray, advances: np.ndarray) -> None:
        expected = self._ages[first : first + len(ages)]
        wrong = np.flatnonzero((ages != 0) & (ages != expected))
        if len(wrong):
            row = wrong[0]
            raise FailedPreconditionError(
                f"encoded observations: environment {first + row} is at age {ages[row]}, after "
                f"what was decoded before it would be {expected[row]} or 0: answers are missing "
                "or came twice"
            )
        if (advances >= self._stack).any() or (advances[ages[: len(advances)] == 0] != 0).any():
            raise _damaged(f"a stack of {self._stack} moves by {advances.max()}")

    def _read_blocks(self, reader: _Reader, count: int) -> _Blocks:
        changed = reader.take(count * -(-self._block_count // 8)).reshape(count, -1)
        changed = _bits(changed).reshape(count, -1)
        if changed[:, self._block_count :].any():
            raise _damaged("a block changes that the picture has not")
        rows, indices = np.nonzero(changed)
        move_rows = reader.take(len(rows)).view(np.int8)
        move_columns = reader.take(len(rows)).view(np.int8)
        patched_rows = _bits(reader.take(len(rows))).view(bool)
        masks = _bits(reader.take(int(patched_rows.sum()))).view(bool)
        if not masks.any(axis=1).all():
            raise _damaged("no pixel is patched in a row")
        patched = np.zeros((len(rows), _SIDE, _SIDE), bool)
        patched[patched_rows] = masks
        self._check_inside(indices, patched)
        pixels = reader.take(int(masks.sum()) * self._pixel_bytes).reshape(-1, self._pixel_bytes)
        reader.end()
        return _Blocks(rows, indices, np.array([move_rows, move_columns], int), patched, pixels)

    def _check_inside(self, indices: np.ndarray, patched: np.ndarray) -> None:
        """Sees that blocks at the last row and column, which may be smaller, stay inside."""
        height = self._rows - (self._block_rows - 1) * _SIDE
        width = self._columns - (self._block_columns - 1) * _SIDE
        lowest = indices // self._block_columns == self._block_rows - 1
        rightmost = indices % self._block_columns == self._block_columns - 1
        if patched[lowest, height:].any() or patched[rightmost, :, width:].any():
            raise _damaged("a row or a pixel is patched that the picture has not")

    def _basis(self, first: int, ages: np.ndarray, advances: np.ndarray) -> np.ndarray:
        """What the observations follow from: uint8 [n, rows, columns, pixel_bytes]."""
        basis = self._shown[first : first + len(ages)]
        if advances.any():
            stacks = basis.reshape(len(ages), self._stack, -1)
            places = np.arange(self._stack) + advances[:, np.newaxis].astype(int)
            places = np.minimum(places, self._stack - 1)
            stacks = np.take_along_axis(stacks, places[:, :, np.newaxis], axis=1)
            basis = stacks.reshape(basis.shape)
        if not ages.all():
            basis = basis.copy()
            basis[ages == 0] = 0
        return basis

    def _changed(self, basis: np.ndarray, blocks: _Blocks) -> np.ndarray:
        """Puts the changed blocks into a copy of their basis."""
        values = self._moved(basis, blocks)
        values[blocks.patched] = blocks.pixels
        padded = ((0, 0), *self._padding(), (0, 0))
        observations = np.pad(basis, padded) if any(map(any, padded)) else basis.copy()
        in_blocks = observations.reshape(
            len(basis), self._block_rows, _SIDE, self._block_columns, _SIDE, self._pixel_bytes
        )
        block_rows, block_columns = np.divmod(blocks.indices, self._block_columns)
        in_blocks[blocks.rows, block_rows, :, block_columns] = values
        return np.ascontiguousarray(observations[:, : self._rows, : self._columns])

    def _padding(self) -> tuple[tuple[int, int], tuple[int, int]]:
        """Rows and columns that are missing to whole blocks."""
        return (0, -self._rows % _SIDE), (0, -self._columns % _SIDE)

    def _moved(self, basis: np.ndarray, blocks: _Blocks) -> np.ndarray:
        """What the moved blocks show before they are patched: uint8 [m, 8, 8, pixel_bytes]."""
        # With eight pixels of the edge on both sides each row of a block is a piece of its row.
        wide = np.pad(basis, ((0, 0), (0, 0), (_SIDE, _SIDE), (0, 0)), mode="edge")
        block_rows, block_columns = np.divmod(blocks.indices, self._block_columns)
        rows = (block_rows * _SIDE + blocks.moves[0])[:, np.newaxis] + np.arange(_SIDE)
        rows = np.clip(rows, 0, self._rows - 1)
        columns = np.clip(block_columns * _SIDE + blocks.moves[1], -_SIDE, self._columns)
        lines = blocks.rows[:, np.newaxis] * self._rows + rows
        starts = lines * wide.shape[2] + (columns + _SIDE)[:, np.newaxis]
        piece = _SIDE * self._pixel_bytes
        pieces: np.ndarray = np.ndarray(
            (wide.size // self._pixel_bytes - _SIDE + 1,),
            np.dtype((np.void, piece)),
            wide,
            strides=(self._pixel_bytes,),
        )
        values = pieces[starts]
        return values.view(np.uint8).reshape(-1, _SIDE, _SIDE, self._pixel_bytes)
