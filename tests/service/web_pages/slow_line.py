#!/usr/bin/env python3
"""A TCP proxy that delays all bytes, like a long line, and limits their rate, like a thin one.

Usage: slow_line.py HOST PORT DELAY_MS BYTES_PER_SECOND. It listens on loopback, prints its port,
and ends when its standard input does. The delay and the rate are those of each direction. A thin
line holds about RECEIVE_BUFFER_BYTES of each connection and direction; more waits at the sender.
"""

import asyncio
import socket
import sys

READ_BYTES = 4096
# With the larger buffers of the kernel, the line would have a long queue.
RECEIVE_BUFFER_BYTES = 16384
# Time that the line catches up after a timer was late.
LATENESS_S_MAX = 0.5


async def carry(source: socket.socket, sink: socket.socket, delay_s: float, rate: float) -> None:
    """Carries bytes from `source` to `sink` until either ends; `rate`: in bytes per second."""
    loop = asyncio.get_running_loop()
    on_the_way: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue()

    async def receive() -> None:
        is_free_at = 0.0
        data = b"some"
        while data:
            data = await loop.sock_recv(source, READ_BYTES)
            on_the_way.put_nowait((loop.time() + delay_s, data))
            is_free_at = max(is_free_at, loop.time() - LATENESS_S_MAX) + len(data) / rate
            await asyncio.sleep(is_free_at - loop.time())

    async def deliver() -> None:
        data = b"some"
        while data:
            due, data = await on_the_way.get()
            await asyncio.sleep(due - loop.time())
            await loop.sock_sendall(sink, data)
        sink.shutdown(socket.SHUT_WR)

    async with asyncio.TaskGroup() as both:
        both.create_task(receive())
        both.create_task(deliver())


async def carry_both_ways(
    near: socket.socket, target: tuple[str, int], delay_s: float, rate: float
) -> None:
    """Serves a connection until both sides have ended it or one has broken it."""
    with near, socket.socket() as far:
        for end in near, far:
            end.setblocking(False)
            end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        far.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
        try:
            await asyncio.get_running_loop().sock_connect(far, target)
            async with asyncio.TaskGroup() as both:
                both.create_task(carry(near, far, delay_s, rate))
                both.create_task(carry(far, near, delay_s, rate))
        except* OSError:
            pass  # a side broke the connection: the other one notices that it is closed


async def serve(target: tuple[str, int], delay_s: float, rate: float) -> None:
    """Accepts connections until standard input ends."""
    loop = asyncio.get_running_loop()
    connections: set[asyncio.Task[None]] = set()
    with socket.create_server(("127.0.0.1", 0)) as listener:
        listener.setblocking(False)
        # Of its connections: they inherit it.
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
        print(listener.getsockname()[1], flush=True)
        input_ended = loop.run_in_executor(None, sys.stdin.read)
        while True:
            accepting = asyncio.create_task(loop.sock_accept(listener))
            await asyncio.wait({accepting, input_ended}, return_when=asyncio.FIRST_COMPLETED)
            if input_ended.done():
                return
            near, _ = accepting.result()
            connection = asyncio.create_task(carry_both_ways(near, target, delay_s, rate))
            connections.add(connection)
            connection.add_done_callback(connections.discard)


host, port, delay_ms, bytes_per_second = sys.argv[1:]
asyncio.run(serve((host, int(port)), float(delay_ms) / 1000, float(bytes_per_second)))
