"""A client of the web protocol: a WebSocket with the messages of server/web/json/README.md."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import re
import struct
import subprocess
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import websockets
from websockets.legacy.client import WebSocketClientProtocol

from procgen_client import ServerProcess

# Longer than any response takes, on the slowest machine and under sanitizers.
TIMEOUT_S = 60.0


class PageError(Exception):
    """An error response."""

    def __init__(self, error: dict[str, str]) -> None:
        super().__init__(f"{error['code']}: {error['message']}")
        self.code = error["code"]
        self.message = error["message"]


class Answer(NamedTuple):
    """A result, and the bytes of its parts by name."""

    result: dict[str, Any]
    parts: dict[str, bytes]
    entries: list[dict[str, Any]]


def binary(header: dict[str, Any], parts: list[dict[str, Any]], *contents: bytes) -> bytes:
    """Returns a binary message."""
    text = json.dumps({**header, "parts": parts}).encode()
    return struct.pack("<I", len(text)) + text + b"".join(contents)


def parse(message: str | bytes) -> tuple[dict[str, Any], list[bytes]]:
    """Returns the JSON of a message and the bytes of its parts."""
    if isinstance(message, str):
        return json.loads(message), []
    (length,) = struct.unpack_from("<I", message)
    header = json.loads(message[4 : 4 + length])
    contents, at = [], 4 + length
    for part in header["parts"]:
        contents.append(message[at : at + part["bytes"]])
        at += part["bytes"]
    assert at == len(message)
    return header, contents


class Page:
    """An open socket. A task receives responses and events."""

    def __init__(self, socket: WebSocketClientProtocol) -> None:
        self.socket = socket
        self._next_id = 1
        self._answers: dict[int, asyncio.Future[Answer]] = {}
        self._events: dict[str, asyncio.Queue[Answer]] = {}
        self._reader = asyncio.create_task(self._read())

    async def _read(self) -> None:
        with contextlib.suppress(websockets.ConnectionClosed):
            async for message in self.socket:
                self._take(*parse(message))
        for answer in self._answers.values():
            if not answer.done():
                answer.set_exception(ConnectionError("the socket was closed"))

    def _take(self, header: dict[str, Any], contents: list[bytes]) -> None:
        entries = header.get("parts", [])
        parts = {entry["name"]: bytes_ for entry, bytes_ in zip(entries, contents)}
        if "event" in header:
            self._queue(header["event"]).put_nowait(Answer(header, parts, entries))
            return
        answer = self._answers.pop(header["id"])
        if "error" in header:
            answer.set_exception(PageError(header["error"]))
        else:
            answer.set_result(Answer(header["result"], parts, entries))

    def _queue(self, event: str) -> asyncio.Queue[Answer]:
        return self._events.setdefault(event, asyncio.Queue())

    def send(self, method: str, *contents: bytes, **members: Any) -> asyncio.Future[Answer]:
        """Sends a request; `contents`: traces, sent as its parts."""
        request = {"id": self._next_id, "method": method, **members}
        self._next_id += 1
        answer: asyncio.Future[Answer] = asyncio.get_running_loop().create_future()
        self._answers[request["id"]] = answer
        parts = [{"name": "trace", "format": "trace", "bytes": len(it)} for it in contents]
        message = binary(request, parts, *contents) if contents else json.dumps(request)
        asyncio.ensure_future(self.socket.send(message))
        return answer

    async def call(self, method: str, *contents: bytes, **members: Any) -> Answer:
        """Sends a request and waits for its response."""
        return await asyncio.wait_for(self.send(method, *contents, **members), TIMEOUT_S)

    async def event(self, name: str) -> Answer:
        """Waits for the next event named `name`."""
        return await asyncio.wait_for(self._queue(name).get(), TIMEOUT_S)

    def has_event(self, name: str) -> bool:
        return not self._queue(name).empty()

    async def closed(self) -> tuple[int, str]:
        """Waits until the server closes the socket; returns code and reason."""
        await asyncio.wait_for(self.socket.wait_closed(), TIMEOUT_S)
        return self.socket.close_code, self.socket.close_reason


@contextlib.asynccontextmanager
async def open_page(
    url: str, *, token: str | None = None, says_hello: bool = True, **options: Any
) -> AsyncIterator[Page]:
    """Opens the socket of the page at `url`, "http://HOST:PORT/", and sends hello."""
    origin = url.rstrip("/")
    address = origin.replace("http", "ws", 1) + "/socket"
    connection = {"origin": origin, "max_size": None, "compression": None, **options}
    async with websockets.connect(address, **connection) as socket:  # type: ignore[attr-defined]
        page = Page(socket)
        if says_hello:
            await page.call("hello", **({} if token is None else {"token": token}))
        yield page


def built(program: str) -> Path:
    """A built program: next to PROCGEN_SERVER_BINARY, else the newest build of this checkout."""
    if "PROCGEN_SERVER_BINARY" in os.environ:
        return Path(os.environ["PROCGEN_SERVER_BINARY"]).parent / program
    found = list(Path(__file__).resolve().parents[3].glob(f"build/*/bin/{program}"))
    assert found, f"no {program} was built"
    return max(found, key=lambda path: path.stat().st_mtime)


def conformance(trace: bytes, folder: Path) -> str:
    """Returns the output of procgen-conformance for a trace."""
    file = folder / "played.trace"
    file.write_bytes(trace)
    outcome = subprocess.run(
        [built("procgen-conformance"), file], stdout=subprocess.PIPE, text=True, check=False
    )
    return outcome.stdout


class WebServer(NamedTuple):
    """A running server with pages."""

    process: ServerProcess
    url: str
    log_path: Path

    @property
    def port(self) -> int:
        return int(self.url.rstrip("/").rsplit(":", 1)[1])


@contextlib.contextmanager
def serve(folder: Path, *flags: str) -> Iterator[WebServer]:
    """Runs a server with pages; expects that it exits with status 0."""
    log_path = folder / "server.log"
    with ServerProcess(
        built("procgen-server"),
        ["--workers=2", "--web_address=127.0.0.1:0", *flags],
        log_path=log_path,
    ) as process:
        url = re.search(r" web=(\S+)", log_path.read_text())
        assert url is not None, log_path.read_text()
        yield WebServer(process, url.group(1), log_path)
        assert process.stop() == 0, log_path.read_text()
