"""What becomes of connections where the process forks: the child has none, and can make its own.

gRPC's connections cannot be used on both sides of a fork. A child loads the native module once
more, which has a gRPC of its own (_transport). grpcio cannot be loaded twice, so where it carries
the calls a child is refused connections of its own.
"""

from __future__ import annotations

import os
import weakref
from typing import Protocol


class ProcessBound(Protocol):
    """Something that belongs to the process that made it."""

    def abandon(self) -> None:
        """In a forked child: leaves what it has to the parent, and sends nothing."""


_bound: weakref.WeakSet[ProcessBound] = weakref.WeakSet()


def bind(owned: ProcessBound) -> None:
    """Has something abandoned in children that are forked from now on."""
    _bound.add(owned)


def _after_fork_in_child() -> None:
    for owned in list(_bound):
        owned.abandon()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork_in_child)
