"""Blocking calls of a library, during which Python handles signals such as Ctrl-C."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TypeVar

_Result = TypeVar("_Result")


def run(call: Callable[[], _Result]) -> _Result:
    """Calls a function and returns its result, or raises its exception.

    On the main thread, the only one that gets signals, it runs on a thread of its own. An exception
    of a signal handler leaves that thread behind, which ends with the call.
    """
    if threading.current_thread() is not threading.main_thread():
        return call()
    results: list[_Result] = []
    errors: list[BaseException] = []

    def target() -> None:
        try:
            results.append(call())
        except BaseException as error:
            errors.append(error)

    thread = threading.Thread(target=target, name="procgen-call", daemon=True)
    thread.start()
    thread.join()
    if errors:
        raise errors[0]
    return results[0]
