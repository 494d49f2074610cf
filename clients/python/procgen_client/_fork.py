"""Detaches a forked child from its parent's connections.

A gRPC connection works in one process only. A child loads the native module again, with a separate
copy of gRPC (_transport). grpcio cannot be loaded twice, so there a child cannot connect.
"""

from __future__ import annotations

import os
import weakref
from typing import Protocol


class ProcessBound(Protocol):
    """An object that only the process that made it may use."""

    def abandon(self) -> None:
        """In a forked child: leaves the resources to the parent, and sends nothing."""


_bound: weakref.WeakSet[ProcessBound] = weakref.WeakSet()


def bind(owned: ProcessBound) -> None:
    """Calls `owned.abandon()` in all children that are forked from now on."""
    _bound.add(owned)


def _after_fork_in_child() -> None:
    for owned in list(_bound):
        owned.abandon()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork_in_child)
