"""Header blocks of HTTP/2 (RFC 7541), as far as gRPC calls need them.

Writes literal fields. Reads all forms except the dynamic table, which the reader's settings
disable. Values are printable ASCII, as all metadata of gRPC.
"""

from __future__ import annotations

from collections.abc import Iterable

# The static table's entries for :status, indices 8 to 14. The names of other fields do not matter.
_STATUS_BEGIN = 8
_STATUSES = ("200", "204", "206", "304", "400", "404", "500")
_STATIC_COUNT = 61

# Lengths in bits of the Huffman codes of bytes 32 to 126 (appendix B). The code is canonical, so
# the lengths determine it. Codes of other bytes are longer.
_CODE_LENGTHS = (
    6, 10, 10, 12, 13, 6, 8, 11, 10, 10, 8, 11, 8, 6, 6, 6,
    5, 5, 5, 6, 6, 6, 6, 6, 6, 6, 7, 8, 15, 6, 12, 10,
    13, 6, *[7] * 22, 8, 7, 8, 13, 19, 13, 14, 6,
    15, 5, 6, 5, 6, 5, 6, 6, 6, 5, 7, 7, 6, 6, 6, 5,
    6, 7, 6, 5, 5, 6, 7, 7, 7, 7, 7, 15, 11, 14, 13,
)  # fmt: skip
_FIRST_CODED = 32


class HeaderError(Exception):
    """A header block is invalid."""


def write_headers(headers: Iterable[tuple[str, str]]) -> bytes:
    """Returns a header block of literal fields without indexing."""
    return b"".join(b"\0" + _string(name) + _string(value) for name, value in headers)


def read_headers(block: bytes) -> list[tuple[str, str]]:
    """Returns the fields of a header block. Names that do not matter are empty.

    Raises:
        HeaderError: The block is damaged, or uses the dynamic table.
    """
    headers: list[tuple[str, str]] = []
    position = 0
    try:
        while position < len(block):
            first = block[position]
            if first & 0xE0 == 0x20:  # A new size of the dynamic table.
                _, position = _number(block, position, 5)
            elif first & 0x80:
                index, position = _number(block, position, 7)
                headers.append(_static(index))
            else:
                index, position = _number(block, position, 6 if first & 0x40 else 4)
                if index:
                    name = _static(index)[0]
                else:
                    name, position = _text(block, position)
                value, position = _text(block, position)
                headers.append((name, value))
    except (IndexError, UnicodeDecodeError) as error:
        raise HeaderError(f"a header block is damaged: {error}") from error
    return headers


def _static(index: int) -> tuple[str, str]:
    if not 1 <= index <= _STATIC_COUNT:
        raise HeaderError(f"a header has index {index}; there are {_STATIC_COUNT}")
    if _STATUS_BEGIN <= index < _STATUS_BEGIN + len(_STATUSES):
        return ":status", _STATUSES[index - _STATUS_BEGIN]
    return "", ""


def _string(text: str) -> bytes:
    written = text.encode("ascii")
    length = len(written)
    if length < 0x7F:
        return bytes((length,)) + written
    head, length = bytearray((0x7F,)), length - 0x7F
    while length >= 0x80:
        head.append(length & 0x7F | 0x80)
        length >>= 7
    head.append(length)
    return bytes(head) + written


def _number(block: bytes, position: int, prefix_bits: int) -> tuple[int, int]:
    """Reads an integer with a prefix of `bits` bits; returns it and the position after it."""
    most = (1 << prefix_bits) - 1
    value = block[position] & most
    position += 1
    if value < most:
        return value, position
    for shift in range(0, 35, 7):
        byte = block[position]
        position += 1
        value += (byte & 0x7F) << shift
        if byte < 0x80:
            return value, position
    raise HeaderError("a number in a header block is too large")


def _text(block: bytes, position: int) -> tuple[str, int]:
    is_coded = block[position] & 0x80
    length, position = _number(block, position, 7)
    written = block[position : position + length]
    if len(written) < length:
        raise HeaderError(f"a header block ends within a text of {length} bytes")
    return (_decoded(written) if is_coded else written.decode("ascii")), position + length


def _codes() -> dict[tuple[int, int], str]:
    """Returns characters by length and code: codes ascend by length, then by byte."""
    codes: dict[tuple[int, int], str] = {}
    code, last_length = 0, 0
    for length, byte in sorted((length, i) for i, length in enumerate(_CODE_LENGTHS)):
        code <<= length - last_length
        codes[length, code] = chr(_FIRST_CODED + byte)
        code, last_length = code + 1, length
    return codes


_CODES = _codes()


def _decoded(written: bytes) -> str:
    characters: list[str] = []
    length = code = 0
    for byte in written:
        for shift in range(7, -1, -1):
            code = code << 1 | byte >> shift & 1
            length += 1
            if (length, code) in _CODES:
                characters.append(_CODES[length, code])
                length = code = 0
    if length > 7 or code != (1 << length) - 1:  # The last byte is padded with ones.
        raise HeaderError("a text in a header block is not of printable ASCII")
    return "".join(characters)
