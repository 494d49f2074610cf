"""What becomes of connections where the process forks: the child has none, and can make its own.

grpcio's connections cannot be made on both sides of a fork. A child that makes one adds its sockets
to the epoll set of its parent, which crashes the parent. With GRPC_ENABLE_FORK_SUPPORT one child in
six hangs. So Client has none where it can do without (_http2_channel.py).
"""

from __future__ import annotations

import os
import weakref
from typing import Protocol

from procgen_client.errors import FailedPreconditionError


class ProcessBound(Protocol):
    """Something that belongs to the process that made it."""

    def abandon(self) -> None:
        """In a forked child: closes the child's copies of file descriptors and sends nothing."""


_bound: weakref.WeakSet[ProcessBound] = weakref.WeakSet()
# Process that has connections of grpcio, of which this one is a child. 0: there are none.
_grpc_process_id = 0


def bind(owned: ProcessBound) -> None:
    """Has something abandoned in children that are forked from now on."""
    _bound.add(owned)


def use_grpc(address: str) -> None:
    """Notes that this process connects to `address` by grpcio.

    Raises:
        FailedPreconditionError: It was forked from one that does, too.
    """
    global _grpc_process_id
    if _grpc_process_id not in (0, os.getpid()):
        raise FailedPreconditionError(
            f"process {os.getpid()} cannot connect to {address}: it was forked from process "
            f"{_grpc_process_id}, which has connections by grpcio (TLS, asyncio, a proxy, or "
            'channel_options). Start processes by multiprocessing.get_context("spawn"), or connect '
            "after forking only"
        )
    _grpc_process_id = os.getpid()


def _after_fork_in_child() -> None:
    for owned in list(_bound):
        owned.abandon()


os.register_at_fork(after_in_child=_after_fork_in_child)
