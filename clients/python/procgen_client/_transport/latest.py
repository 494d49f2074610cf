"""What a call tells again and again, each time anew and whole."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterable, Iterator
from typing import TypeVar

_Message = TypeVar("_Message")


def latest_of(call: Iterable[_Message]) -> Iterator[_Message]:
    """Gives a call's messages as they come.

    Whoever takes long between two of them gets the latest of those that came meanwhile and misses
    the others, for which there would be room in buffers of megabytes. Ends as the call does; the
    caller ends the call.
    """
    changed = threading.Condition()
    latest: deque[_Message] = deque(maxlen=1)
    end: list[BaseException | None] = []

    def take() -> None:
        failure: BaseException | None = None
        try:
            for message in call:
                with changed:
                    latest.append(message)
                    changed.notify()
        except BaseException as error:  # Of whoever reads.
            failure = error
        with changed:
            end.append(failure)
            changed.notify()

    threading.Thread(target=take, name="procgen-latest", daemon=True).start()
    while True:
        with changed:
            changed.wait_for(lambda: latest or end)
            if not latest:
                break
            message = latest.popleft()
        yield message
    if end[0] is not None:
        raise end[0]
