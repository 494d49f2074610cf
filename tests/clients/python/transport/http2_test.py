"""Calls of gRPC past grpcio, to a server that is played here, byte for byte."""

from __future__ import annotations

import os
import signal
import socket
import struct
import threading
from collections.abc import Iterator
from pathlib import Path

import grpc
import pytest

from procgen_client import Client, Reset, ServerProcess, errors
from procgen_client._transport import http2 as _http2
from procgen_client._transport.hpack import read_headers, write_headers
from procgen_client._transport.http2 import Http2Call
from procgen_client._transport.target import Target

_PREFACE_BYTES = 24
_DATA, _HEADERS, _RST_STREAM, _SETTINGS, _PING, _GOAWAY, _WINDOW_UPDATE, _CONTINUATION = (
    0, 1, 3, 4, 6, 7, 8, 9
)  # fmt: skip


class Played:
    """The server's end of a connection, which the test plays."""

    def __init__(self, connection: socket.socket) -> None:
        self.connection = connection
        connection.settimeout(60)
        assert self._take(_PREFACE_BYTES).startswith(b"PRI * HTTP/2.0")
        self.settings = self.read()
        self.window = self.read()
        kind, _, _, block = self.read()
        assert kind == _HEADERS
        self.headers = dict(read_headers(block))

    def read(self) -> tuple[int, int, int, bytes]:
        """Gives the next frame: type, flags, stream, content."""
        head = self._take(9)
        length = int.from_bytes(head[:3], "big")
        return head[3], head[4], int.from_bytes(head[5:], "big"), self._take(length)

    def write(self, kind: int, flags: int, stream: int, content: bytes) -> None:
        head = len(content).to_bytes(3, "big") + struct.pack("!BBI", kind, flags, stream)
        self.connection.sendall(head + content)

    def answer(self) -> None:
        self.write(_HEADERS, 4, 1, write_headers([(":status", "200")]))

    def end(self, *trailers: tuple[str, str]) -> None:
        self.write(_HEADERS, 5, 1, write_headers(trailers))

    def _take(self, size: int) -> bytes:
        taken = b""
        while len(taken) < size:
            more = self.connection.recv(size - len(taken))
            assert more, "the client has closed the connection"
            taken += more
        return taken


@pytest.fixture
def ends(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Http2Call, Played]]:
    """A call and the server's end of it; nobody keeps it alive unless a test does."""
    monkeypatch.setattr(_http2, "_KEEPER_SECONDS", 3600)
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
        metadata = [("authorization", "Bearer x")]
        call = Http2Call(Target(None, "127.0.0.1", port), "/a/B", metadata)
        connection, _ = listener.accept()
        with connection:
            yield call, Played(connection)
            call.cancel()


def _message(content: bytes) -> bytes:
    return struct.pack("!BI", 0, len(content)) + content


def test_a_call_begins_as_grpc_has_it(ends: tuple[Http2Call, Played]) -> None:
    call, played = ends
    assert played.headers == {
        ":method": "POST",
        ":scheme": "http",
        ":path": "/a/B",
        ":authority": f"127.0.0.1:{played.connection.getsockname()[1]}",
        "te": "trailers",
        "content-type": "application/grpc",
        "user-agent": "procgen-client-python",
        "authorization": "Bearer x",
    }
    settings = dict(struct.iter_unpack("!HI", played.settings[3]))
    assert settings == {1: 0, 2: 0, 4: 2**31 - 1, 5: 2**24 - 1}
    call.send(b"abc")
    assert played.read() == (_DATA, 0, 1, _message(b"abc"))
    call.end_requests()
    assert played.read() == (_DATA, 1, 1, b"")


def test_messages_arrive_however_they_are_cut(ends: tuple[Http2Call, Played]) -> None:
    call, played = ends
    messages = [bytes([i]) * size for i, size in enumerate((1, 0, 5, 40000, 3, 100000))]
    whole = b"".join(map(_message, messages))
    cuts = [*range(0, 20), 30, 20000, 40030, 40040, len(whole)]
    played.answer()

    def write() -> None:
        for begin, end in zip(cuts, cuts[1:], strict=False):
            played.write(_DATA, 0, 1, whole[begin:end])
            played.write(_DATA, 8, 1, b"\3" + b"" + b"pad")  # Nothing but padding.
            played.write(0xBE, 0, 0, b"of a kind that nobody knows")

    writer = threading.Thread(target=write)
    writer.start()
    for message in messages:
        received = call.receive()
        assert received is not None
        assert received.readonly
        assert bytes(received) == message
    writer.join()
    played.end(("grpc-status", "0"))
    assert call.receive() is None
    assert call.receive() is None


def test_several_messages_of_one_frame_arrive(ends: tuple[Http2Call, Played]) -> None:
    call, played = ends
    played.write(_DATA, 8, 1, b"\2" + _message(b"a") + _message(b"bc") + b"\0\0")
    assert bytes(call.receive() or b"") == b"a"
    assert bytes(call.receive() or b"") == b"bc"


@pytest.mark.parametrize(
    "trailers,code,details",
    [
        ([("grpc-status", "5"), ("grpc-message", "a%20pool: %E2%82%AC")], "NOT_FOUND", "a pool: €"),
        ([("grpc-status", "14"), ("procgen-drains", "1")], "UNAVAILABLE", ""),
        ([("grpc-status", "99")], "UNKNOWN", ""),
        ([], "UNKNOWN", "HTTP status 200"),
        ([(":status", "503")], "UNAVAILABLE", "HTTP status 503"),
        ([("grpc-status", "abc")], "INTERNAL", "invalid literal"),
    ],
)
def test_the_end_is_told(
    ends: tuple[Http2Call, Played], trailers: list[tuple[str, str]], code: str, details: str
) -> None:
    call, played = ends
    played.answer()
    played.end(*trailers)
    with pytest.raises(grpc.RpcError) as raised:
        call.receive()
    assert raised.value.code() == grpc.StatusCode[code]
    assert details in raised.value.details()
    if code == "UNAVAILABLE" and not details:
        assert ("procgen-drains", "1") in raised.value.trailing_metadata()


def test_trailers_may_come_in_pieces(ends: tuple[Http2Call, Played]) -> None:
    call, played = ends
    block = write_headers([("grpc-status", "3"), ("grpc-message", "m" * 300)])
    # With padding and a priority, which say nothing.
    played.write(_HEADERS, 1 | 8 | 32, 1, b"\4" + bytes(5) + block[:100] + bytes(4))
    played.write(_CONTINUATION, 0, 1, block[100:200])
    played.write(_CONTINUATION, 4, 1, block[200:])
    with pytest.raises(grpc.RpcError) as raised:
        call.receive()
    assert raised.value.code() == grpc.StatusCode.INVALID_ARGUMENT
    assert raised.value.details() == "m" * 300


@pytest.mark.parametrize(
    "frame,code",
    [
        ((_RST_STREAM, 0, 1, b"\0\0\0\7"), "UNAVAILABLE"),
        ((_RST_STREAM, 0, 1, b"\0\0\0\x0b"), "RESOURCE_EXHAUSTED"),
        ((_RST_STREAM, 0, 1, b"\0\0\0\2"), "INTERNAL"),
        ((_GOAWAY, 0, 0, bytes(8)), "UNAVAILABLE"),
        ((_DATA, 0, 1, b"\1\0\0\0\1x"), "INTERNAL"),  # Compressed.
        ((_DATA, 1, 1, b""), "INTERNAL"),  # An end without trailers.
        ((_HEADERS, 5, 1, b"\xff\xff\xff\xff\xff\xff\xff"), "INTERNAL"),
        ((_HEADERS, 12, 1, b""), "INTERNAL"),
        ((_SETTINGS, 0, 0, b"\0"), "INTERNAL"),
        ((_DATA, 0, 1, b"\0\x10\0\0\1"), "INTERNAL"),  # More than is received.
        ((_HEADERS, 0, 1, bytes((1 << 16) + 1)), "INTERNAL"),
        ((_SETTINGS, 0, 0, bytes((1 << 16) + 1)), "INTERNAL"),
    ],
)
def test_resets_and_nonsense_end_the_call(
    ends: tuple[Http2Call, Played], frame: tuple[int, int, int, bytes], code: str
) -> None:
    call, played = ends
    played.write(*frame)
    with pytest.raises(grpc.RpcError) as raised:
        call.receive()
    assert raised.value.code() == grpc.StatusCode[code]


def test_a_server_that_goes_away_later_is_heard_out(ends: tuple[Http2Call, Played]) -> None:
    call, played = ends
    played.write(_GOAWAY, 0, 0, b"\x7f\xff\xff\xff" + bytes(4))
    played.write(_DATA, 0, 1, _message(b"more"))
    assert bytes(call.receive() or b"") == b"more"


def test_a_connection_that_breaks_is_unavailable(ends: tuple[Http2Call, Played]) -> None:
    call, played = ends
    played.write(_DATA, 0, 1, _message(b"whole") + _message(b"not whole")[:-1])
    played.connection.close()
    assert bytes(call.receive() or b"") == b"whole"
    for _ in range(2):
        with pytest.raises(grpc.RpcError) as raised:
            call.receive()
        assert raised.value.code() == grpc.StatusCode.UNAVAILABLE
        call.send(b"lost")  # That it is over only receive tells.


def test_no_server_is_unavailable() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    call = Http2Call(Target(None, "127.0.0.1", port), "/a/B", [], 1)
    call.send(b"lost")
    with pytest.raises(grpc.RpcError, match="refused") as raised:
        call.receive()
    assert raised.value.code() == grpc.StatusCode.UNAVAILABLE


def test_what_is_sent_waits_for_room(ends: tuple[Http2Call, Played]) -> None:
    call, played = ends
    content = bytes(range(256)) * 400
    played.write(_SETTINGS, 0, 0, struct.pack("!HI", 4, 1000))  # Less than what was there before.
    played.write(_DATA, 0, 1, _message(b"so that it is read"))
    assert call.receive() is not None
    assert played.read() == (_SETTINGS, 1, 0, b"")
    sender = threading.Thread(target=call.send, args=(content,))
    sender.start()
    received = b""
    connection_window, stream_window = 65535, 1000
    while len(received) < len(content) + 5:
        kind, _, _, part = played.read()
        assert kind == _DATA
        received += part
        connection_window -= len(part)
        stream_window -= len(part)
        assert min(connection_window, stream_window) >= 0
        if stream_window == 0:
            played.write(_WINDOW_UPDATE, 0, 1, (5000).to_bytes(4, "big"))
            stream_window += 5000
        if connection_window == 0:
            played.write(_WINDOW_UPDATE, 0, 0, (70000).to_bytes(4, "big"))
            connection_window += 70000
    sender.join()
    assert received == _message(content)


def test_windows_are_opened_again(
    ends: tuple[Http2Call, Played], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_http2, "_WINDOW_UPDATE_BYTES", 1000)
    call, played = ends
    assert played.window == (_WINDOW_UPDATE, 0, 0, (2**31 - 2**16).to_bytes(4, "big"))
    for _ in range(2):
        played.write(_DATA, 0, 1, _message(bytes(595)))
        assert call.receive() is not None
    assert played.read() == (_WINDOW_UPDATE, 0, 0, (1200).to_bytes(4, "big"))
    assert played.read() == (_WINDOW_UPDATE, 0, 1, (1200).to_bytes(4, "big"))


def test_signs_of_life_are_given_also_while_nobody_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_http2, "_KEEPER_SECONDS", 0.01)
    with socket.create_server(("127.0.0.1", 0)) as listener:
        call = Http2Call(Target(None, "127.0.0.1", listener.getsockname()[1]), "/a/B", [])
        connection, _ = listener.accept()
        with connection:
            played = Played(connection)
            played.write(_DATA, 0, 1, _message(b"kept"))
            played.write(_PING, 0, 0, b"12345678")
            assert played.read() == (_PING, 1, 0, b"12345678")
            assert bytes(call.receive() or b"") == b"kept"
            call.cancel()


def test_a_silent_server_is_asked_and_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_http2, "_SILENCE_SECONDS", 1)
    with socket.create_server(("127.0.0.1", 0)) as listener:
        call = Http2Call(Target(None, "127.0.0.1", listener.getsockname()[1]), "/a/B", [])
        connection, _ = listener.accept()
        with connection:
            played = Played(connection)
            caught: list[grpc.RpcError] = []

            def receive() -> None:
                try:
                    call.receive()
                except grpc.RpcError as error:
                    caught.append(error)

            waiting = threading.Thread(target=receive)
            waiting.start()
            for _ in range(2):  # A sign of life gives it time again.
                assert played.read() == (_PING, 0, 0, bytes(8))
                if not caught:
                    played.write(_PING, 1, 0, bytes(8))
            assert played.read() == (_PING, 0, 0, bytes(8))
            waiting.join()
            assert caught[0].code() == grpc.StatusCode.UNAVAILABLE
            assert "silent for 2 s" in caught[0].details()


def test_who_waits_is_woken_when_the_call_is_given_up(ends: tuple[Http2Call, Played]) -> None:
    call, _ = ends
    caught: list[grpc.RpcError] = []

    def receive() -> None:
        try:
            call.receive()
        except grpc.RpcError as error:
            caught.append(error)

    waiting = threading.Thread(target=receive)
    waiting.start()
    call.cancel()
    waiting.join()
    assert caught[0].code() == grpc.StatusCode.CANCELLED


@pytest.mark.parametrize(
    "address,target,authority",
    [
        ("localhost:5", Target(None, "localhost", 5), "localhost:5"),
        ("dns:///a-b.example.com:5", Target(None, "a-b.example.com", 5), "a-b.example.com:5"),
        ("[::1]:5", Target(None, "::1", 5), "[::1]:5"),
        ("unix:/run/a.sock", Target("/run/a.sock", "localhost", 0), "localhost"),
        ("unix:///run/a.sock", Target("/run/a.sock", "localhost", 0), "localhost"),
        ("unix:a.sock", Target("a.sock", "localhost", 0), "localhost"),
        ("xds:///somewhere", None, ""),
        ("dns://8.8.8.8/a:5", None, ""),
        ("localhost", None, ""),
    ],
)
def test_addresses_that_sockets_know(address: str, target: Target | None, authority: str) -> None:
    assert Target.of(address) == target
    if target is not None:
        assert target.authority == authority


def test_proxies_are_left_to_grpcio(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("http_proxy", "http://proxy:3128")
    assert Target.of("example.com:5") is None
    assert Target.of("127.0.0.1:5") is not None
    assert Target.of("unix:/run/a.sock") is not None


def test_pictures_come_past_grpcio_where_they_can(server: ServerProcess, client: Client) -> None:
    with client.create_pool("maze", 2) as pool:
        pool.step([4, 4])
        assert pool._stream is not None
        assert isinstance(pool._stream._call, Http2Call)
    # Options of a channel are for grpcio's.
    options = [("grpc.max_concurrent_streams", 100)]
    with Client(server.address, channel_options=options) as other:
        with other.create_pool("maze", 2) as pool:
            batch = pool.step([4, 4])
            assert batch.observations is not None
            assert pool._stream is not None
            assert not isinstance(pool._stream._call, Http2Call)


def test_closing_the_client_ends_streams(server: ServerProcess, client: Client) -> None:
    closed = Client(server.address)
    pool = closed.create_pool("maze", 2)
    pool.step([4, 4])
    closed.close()
    for _ in range(2):
        with pytest.raises(errors.CancelledError):
            pool.step([4, 4])
    client.delete_pool(pool.name)


def test_large_requests_are_sent_whole(client: Client) -> None:
    count = 4096
    with client.create_pool("bigfish", count) as pool:
        resets = [Reset(i, level_seed=2**30 + i, rand_seed=2**50 + i) for i in range(count)]
        batch = pool.reset(resets, observe=False)  # More than the server's first window.
        assert batch.level_seeds.tolist() == list(range(2**30, 2**30 + count))


def test_a_unix_socket_will_do(tmp_path: Path) -> None:
    with ServerProcess(flags=["--workers=1"], address=f"unix:{tmp_path}/socket") as server:
        with Client(server.address) as client, client.create_pool("maze", 2) as pool:
            assert pool.step([4, 4]).observations is not None
            assert pool._stream is not None
            assert isinstance(pool._stream._call, Http2Call)


def test_an_interrupted_wait_ends_the_stream_and_not_the_pool(client: Client) -> None:
    with client.create_pool("maze", 2) as pool:
        pool.step([4, 4])
        stream = pool._stream
        assert stream is not None
        with pytest.raises(KeyboardInterrupt):
            threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
            stream._next_message()  # Nobody has asked for anything.
        pool._stream = None
        pool.attach(take_over=True)
        assert pool.step([4, 4]).env_count == 2
