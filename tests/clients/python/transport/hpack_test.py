"""Header blocks are read as RFC 7541 has them."""

from __future__ import annotations

import pytest

from procgen_client._transport.hpack import HeaderError, read_headers, write_headers


def test_what_is_written_is_read() -> None:
    headers = [
        ("grpc-status", "3"),
        ("grpc-message", "x" * 126),
        ("authorization", "Bearer " + "y" * 500),
        ("procgen-drains", ""),
    ]
    assert read_headers(write_headers(headers)) == headers


@pytest.mark.parametrize(
    "coded,text",
    [  # Of RFC 7541, appendix C.4 to C.6.
        ("f1e3c2e5f23a6ba0ab90f4ff", "www.example.com"),
        ("a8eb10649cbf", "no-cache"),
        ("25a849e95ba97d7f", "custom-key"),
        ("25a849e95bb8e8b4bf", "custom-value"),
        ("6402", "302"),
        ("aec3771a4b", "private"),
        ("d07abe941054d444a8200595040b8166e082a62d1bff", "Mon, 21 Oct 2013 20:13:21 GMT"),
        ("9d29ad171863c78f0b97c8e9ae82ae43d3", "https://www.example.com"),
        (
            "94e7821dd7f2e6c7b335dfdfcd5b3960d5af27087f3672c1"
            "ab270fb5291f9587316065c003ed4ee5b1063d5007",
            "foo=ASDJKHQKBZXOQWEOPIUAXQWEOIU; max-age=3600; version=1",
        ),
    ],
)
def test_huffman_codes_are_read(coded: str, text: str) -> None:
    written = bytes.fromhex(coded)
    block = b"\0\1a" + bytes((0x80 | len(written),)) + written
    assert read_headers(block) == [("a", text)]


def test_all_forms_of_fields_are_read() -> None:
    # The dynamic table has no room; indexed; literal with indexing, without, never.
    fields = (b"\x88", b"\x40\1a\1b", b"\0\1c\1d", b"\x10\1e\1f", b"\x5f\1g", b"\x0f\x02\1h")
    assert read_headers(b"\x20" + b"".join(fields)) == [
        (":status", "200"),
        ("a", "b"),
        ("c", "d"),
        ("e", "f"),
        ("", "g"),  # content-type, whose name does not matter.
        ("", "h"),
    ]


@pytest.mark.parametrize(
    "block",
    [
        b"\0",
        b"\0\1",
        b"\0\1a\5b",
        b"\x80",
        b"\xbe",  # Of the dynamic table.
        b"\x7f\xff\xff\xff\xff\xff\xff\xff",
        b"\0\1a\1\xff",  # No ASCII.
        b"\0\1a\x81\0",  # Its end is not filled up with ones.
        b"\0\1a\x82\xff\xff",  # More than one byte of them.
        b"\0\1a\x84\xff\xff\xff\xfa",  # A line feed: coded in 30 bits.
    ],
)
def test_damaged_blocks_are_errors(block: bytes) -> None:
    with pytest.raises(HeaderError):
        read_headers(block)
