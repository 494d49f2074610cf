"""A connection to a server by libprocgen_remote."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from procgen_client import _interruptible, _library, _structs
from procgen_client.errors import CancelledError

# Longest wait inside the library, so that a signal such as Ctrl-C is handled soon, in seconds.
_WAIT_S = 0.05
_DEADLINE_EXCEEDED = 4


class Connection:
    """A connection. Threads: any method from any thread."""

    def __init__(
        self, library: _library.Library, address: str, options: Mapping[str, Any]
    ) -> None:
        """Connects; `options`: of _library.ConnectOptions. Errors as Client."""
        self._library = library
        size = ctypes.sizeof(_library.ConnectOptions)
        struct = _library.ConnectOptions(struct_size=size, **options)
        handle = ctypes.c_void_p()

        def connect() -> None:
            reference = ctypes.byref(handle)
            library.check(library.connect(address.encode(), ctypes.byref(struct), reference))

        _interruptible.run(connect)
        self._handle = handle

    def __del__(self) -> None:
        """Closes the connection."""
        if hasattr(self, "_handle"):
            self._library.connection_destroy(self._handle)

    def close(self) -> None:
        """Ends all calls, also those of its pools and watches, with CancelledError."""
        self._library.connection_close(self._handle)

    def call(self, path: str, request: bytes) -> bytes:
        """Calls a unary method, such as "/procgen.v1.PoolService/GetPool"."""
        message, size = ctypes.c_void_p(), ctypes.c_size_t()

        def call() -> None:
            self._library.check(
                self._library.connection_call(
                    *(self._handle, path.encode(), request, len(request)),
                    *(ctypes.byref(message), ctypes.byref(size)),
                )
            )

        _interruptible.run(call)
        return self._taken(message, size)

    def watch(self, path: str, request: bytes) -> Iterator[bytes]:
        """Calls a method with a stream of responses; yields them, conflated to the latest."""
        watch = ctypes.c_void_p()
        self._library.check(
            self._library.connection_watch(
                self._handle, path.encode(), request, len(request), ctypes.byref(watch)
            )
        )
        message, size = ctypes.c_void_p(), ctypes.c_size_t()
        references = ctypes.byref(message), ctypes.byref(size)
        try:
            while True:
                code = self._library.watch_next(watch, _WAIT_S, *references)
                if code == _DEADLINE_EXCEEDED:
                    continue
                self._library.check(code)
                yield self._taken(message, size)
        finally:
            self._library.watch_destroy(watch)

    def make_pool(
        self, games: Sequence[str], env_count: int, options: Mapping[str, Any]
    ) -> tuple[_library.Library, ctypes.c_void_p]:
        """Makes a pool on the server; returns its library and its handle.

        Args:
            games: Names of games.
            env_count: Number of environments.
            options: From options.checked_options.
        """
        struct, _kept = _structs.pool_options(self._library, games, env_count, options, None)
        labels = [f"{key}={value}".encode() for key, value in options.get("labels", {}).items()]
        more = _library.ServerPoolOptions(
            struct_size=ctypes.sizeof(_library.ServerPoolOptions),
            pool_id=options.get("pool_id", "").encode() or None,
            encoding=options.get("encoding", 0),
            display_name=options.get("name", "").encode() or None,
            labels=(ctypes.c_char_p * len(labels))(*labels),
            label_count=len(labels),
        )
        handle = ctypes.c_void_p()

        def make() -> None:
            references = ctypes.byref(struct), ctypes.byref(more), ctypes.byref(handle)
            self._library.check(self._library.connection_create_pool(self._handle, *references))

        _interruptible.run(make)
        return self._library, handle

    def _taken(self, message: ctypes.c_void_p, size: ctypes.c_size_t) -> bytes:
        """Returns a message of the library, and frees its memory."""
        try:
            return ctypes.string_at(message.value, size.value) if message.value else b""
        finally:
            self._library.free(message)


def closed_error(address: str) -> CancelledError:
    """Returns the error of calls after the connection was closed."""
    return CancelledError(f"the connection to {address} was closed by this client")
