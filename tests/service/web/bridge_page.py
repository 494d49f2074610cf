"""A client of the bridge: a WebSocket with the messages of proto/procgen/web/v1/bridge.proto.

All message classes come from the descriptors that the server sends to pages.
"""

from __future__ import annotations

import asyncio
import contextlib
import urllib.request
from collections.abc import AsyncIterator, Iterable
from typing import Any

import websockets
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from google.protobuf.message import Message
from websockets.legacy.client import WebSocketClientProtocol

from page import TIMEOUT_S

POOLS = "/procgen.v1.PoolService/"


class CallError(Exception):
    """The end of a call that is not OK."""

    def __init__(self, status: Any) -> None:
        super().__init__(f"{status.code}: {status.message}")
        self.code = status.code
        self.message = status.message
        self.draining = status.draining


class Api:
    """The message classes of a server."""

    def __init__(self, url: str, **options: Any) -> None:
        with urllib.request.urlopen(f"{url}assets/api.binpb", **options) as response:
            files = descriptor_pb2.FileDescriptorSet.FromString(response.read())
        self._pool = descriptor_pool.DescriptorPool()
        for file in files.file:
            self._pool.Add(file)
        self._factory = message_factory.MessageFactory(self._pool)

    def message(self, name: str, /, **fields: Any) -> Any:
        """A message of procgen.v1, or of another package with its full name."""
        full_name = name if "." in name else f"procgen.v1.{name}"
        return self._factory.GetPrototype(self._pool.FindMessageTypeByName(full_name))(**fields)

    def response(self, method: str, content: bytes) -> Any:
        """Parses a response of a method."""
        service, name = method.lstrip("/").rsplit("/", 1)
        found = self._pool.FindServiceByName(service).FindMethodByName(name)
        return self._factory.GetPrototype(found.output_type).FromString(content)


class Call:
    """A call of a page."""

    def __init__(self, page: BridgePage, number: int, method: str) -> None:
        self._page = page
        self.number = number
        self.method = method
        self.received: asyncio.Queue[bytes | Any] = asyncio.Queue()

    async def send(self, *messages: Message | bytes) -> None:
        for message in messages:
            content = message if isinstance(message, bytes) else message.SerializeToString()
            await self._page.send(call=self.number, message=content)

    async def half_close(self) -> None:
        await self._page.send(call=self.number, half_close=True)

    async def cancel(self) -> None:
        await self._page.send(call=self.number, cancel=True)

    async def read_bytes(self) -> bytes | None:
        """The next message; None at an end that is OK. Raises CallError."""
        item = await asyncio.wait_for(self.received.get(), TIMEOUT_S)
        if isinstance(item, bytes):
            return item
        if item.code != 0:
            raise CallError(item)
        return None

    async def read(self) -> Any:
        content = await self.read_bytes()
        return None if content is None else self._page.api.response(self.method, content)


class BridgePage:
    """An open socket. A task receives the messages of all calls."""

    def __init__(self, socket: WebSocketClientProtocol, api: Api) -> None:
        self.socket = socket
        self.api = api
        self.calls: dict[int, Call] = {}
        self._next_number = 1
        self._reader = asyncio.create_task(self._read())

    async def _read(self) -> None:
        with contextlib.suppress(websockets.ConnectionClosed):
            async for message in self.socket:
                response = self.api.message("procgen.web.v1.BridgeResponse")
                response.ParseFromString(message)
                call = self.calls[response.call]
                if response.HasField("end"):
                    del self.calls[response.call]
                    call.received.put_nowait(response.end)
                else:
                    call.received.put_nowait(response.message)

    async def send(self, **fields: Any) -> None:
        request = self.api.message("procgen.web.v1.BridgeRequest", **fields)
        await self.socket.send(request.SerializeToString())

    async def open(self, method: str, *messages: Message | bytes) -> Call:
        """Opens a call and sends its first messages."""
        call = Call(self, self._next_number, method)
        self._next_number += 1
        self.calls[call.number] = call
        await self.send(call=call.number, method=method)
        await call.send(*messages)
        return call

    async def start(self, method: str, message: Message | bytes) -> Call:
        """Opens a call with one request."""
        call = await self.open(method, message)
        await call.half_close()
        return call

    async def ask(self, method: str, message: Message | bytes) -> Any:
        """A unary call."""
        call = await self.start(method, message)
        response = await call.read()
        assert await call.read() is None
        return response

    async def start_pool(self, pool_id: str = "", env_count: int = 1, game: str = "maze") -> Call:
        """Starts a pool, whose levels are always the same, and reads its first response."""
        options = self.api.message("EnvironmentOptions", rand_seed=1)
        spec = self.api.message("PoolSpec", games=[game], env_count=env_count, options=options)
        call = await self.open(f"{POOLS}RunPool", self.run("start", pool_id=pool_id, spec=spec))
        assert (await call.read()).HasField("started")
        return call

    def run(self, kind: str, **fields: Any) -> Any:
        """A RunPoolRequest."""
        request = self.api.message("RunPoolRequest")
        part = getattr(request, kind)
        part.SetInParent()
        part.MergeFrom(type(part)(**fields))
        return request

    def step(self, actions: Iterable[int]) -> Any:
        """A RunPoolRequest that steps all environments."""
        values = list(actions)
        piece = self.api.message("Slice", first_env=0, env_count=len(values))
        return self.run("step", slice=piece, actions=values)

    async def pool_names(self) -> list[str]:
        pools = await self.ask(f"{POOLS}ListPools", self.api.message("ListPoolsRequest"))
        return [pool.name for pool in pools.pools]

    async def closed(self) -> tuple[int, str]:
        """Waits until the server closes the socket; returns code and reason."""
        await asyncio.wait_for(self.socket.wait_closed(), TIMEOUT_S)
        return self.socket.close_code, self.socket.close_reason


@contextlib.asynccontextmanager
async def open_bridge(
    url: str, *, token: str | None = None, api: Api | None = None, **options: Any
) -> AsyncIterator[BridgePage]:
    """Opens the bridge of the server at `url`, "http://HOST:PORT/", and sends a token."""
    origin = url.rstrip("/")
    address = origin.replace("http", "ws", 1) + "/bridge"
    connection = {"origin": origin, "max_size": None, "compression": None, **options}
    async with websockets.connect(address, **connection) as socket:  # type: ignore[attr-defined]
        page = BridgePage(socket, api or Api(url))
        if token is not None:
            await page.send(token=token)
        yield page
