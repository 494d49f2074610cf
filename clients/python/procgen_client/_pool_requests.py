"""The requests of a pool: their structs, the memory of their batches, and waits for them."""

from __future__ import annotations

import ctypes
import threading
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from procgen_client import _library, _structs
from procgen_client._out import writable_view
from procgen_client._requests import ACTION_COUNT, ACTION_MIN, Reset, in_range
from procgen_client.batch import Batch, Buffers
from procgen_client.errors import FailedPreconditionError, InvalidArgumentError, StatusCode

if TYPE_CHECKING:
    from procgen_client.client import Client

# Longest wait inside the library, so that a signal such as Ctrl-C is handled soon, in seconds.
_WAIT_S = 0.05
# Batches whose memory is used again, of one size.
_KEPT_BUFFERS = 4


class Requests:
    """The part of a Pool that prepares its requests."""

    env_count: int
    observation_shape: tuple[int, ...]
    client: Client | None
    _close_once: Any  # The finalizer, a weakref.finalize.
    _library: _library.Library
    _handle: ctypes.c_void_p

    def __init__(self, env_count: int, observation_shape: tuple[int, ...]) -> None:
        """Makes the struct of steps."""
        self.env_count, self.observation_shape = env_count, observation_shape
        # The next step, and the memory of its actions.
        self._actions = np.zeros(self.env_count, np.int32)
        self._step = _library.Step(struct_size=ctypes.sizeof(_library.Step))
        self._step.actions = self._actions.ctypes.data
        self._step_reference = ctypes.byref(self._step)
        self._known: dict[tuple[int, bool, bool], list[Buffers]] = {}
        self._in_flight: deque[Buffers] = deque()
        self._is_interrupted = False  # What is in flight is to be discarded.
        # Held by a call to a server, also by one that an exception of a signal left behind.
        self._calls = threading.Lock()

    @property
    def closed(self) -> bool:
        """Whether close was called."""
        return not self._close_once.alive

    def _step_request(
        self,
        actions: npt.ArrayLike,
        first_env: int,
        env_count: int | None,
        observe: bool,
        repeat_count: int,
        final: bool,
        next_levels: Mapping[int, int] | None,
        resets: Iterable[int | Reset],
        annotations: Mapping[str, npt.ArrayLike] | None,
        out: Any,  # noqa: ANN401
    ) -> tuple[Buffers, object]:
        """Fills the struct of the next step; returns memory for its batch, and what must live."""
        count = self._count_of(first_env, env_count)
        given = np.asarray(actions)
        if given.shape != (count,) or given.dtype.kind not in "iu":
            raise InvalidArgumentError(
                f"actions has shape {list(given.shape)} and type {given.dtype}; it is one integer "
                f"for each of {count} environments from {first_env} on"
            )
        taken = self._actions[:count]
        taken[:] = given
        if given.dtype.itemsize > 4 and np.count_nonzero(taken != given):
            wrong = given[taken != given][0]
            raise InvalidArgumentError(
                f"actions contains {wrong}; actions are {ACTION_MIN} ... {ACTION_COUNT - 1}"
            )
        step = self._step
        step.first_env, step.env_count = first_env, count
        if repeat_count != 1:
            repeat_count = in_range("repeat_count", repeat_count, 1, 1000)
        step.repeat_count = repeat_count
        kept = None
        if next_levels or resets != () or annotations or step.next_level_count:
            next_array = _structs.next_levels(next_levels or {})
            reset_array = _structs.resets(resets)
            step.next_levels, step.next_level_count = next_array, len(next_array)
            step.resets, step.reset_count = reset_array, len(reset_array)
            notes, values = _structs.viewer_annotations(annotations or {}, count)
            step.annotations, step.annotation_count = notes, len(notes)
            kept = (next_array, reset_array, notes, values)
        elif step.reset_count or step.annotation_count:
            step.reset_count = step.annotation_count = 0
        return self._buffers(first_env, count, observe, final, out), kept

    def _buffers(
        self, first_env: int, count: int, observe: bool, final: bool, out: Any  # noqa: ANN401
    ) -> Buffers:
        """Returns memory for a batch: of an earlier one that nothing refers to, or new."""
        view = None
        if out is not None:
            if not observe:
                raise InvalidArgumentError("out is given, but observe is False: there is nothing")
            view = writable_view(out, (count, *self.observation_shape))
            observe = False  # The batch needs no memory for observations.
        key = (count, observe, final)
        known = self._known.setdefault(key, [])
        for buffers in known:
            if buffers.is_idle() and buffers not in self._in_flight:
                break
        else:
            buffers = Buffers(count, self.observation_shape, observe, final)
            # A learner that keeps its batches gets new memory each time.
            known.append(buffers)
            del known[:-_KEPT_BUFFERS]
        buffers.batch.first_env = first_env
        if not observe:
            buffers.set_observations(out, view)
        return buffers

    def _oldest(self) -> Batch:
        """Waits for the batch of the oldest unanswered request."""
        if self._is_interrupted:
            self._discard()
        if not self._in_flight:
            self._check_open()
            raise FailedPreconditionError("no request is unanswered: send one first")
        receive, handle = self._library.receive, self._handle
        try:
            while (code := receive(handle, _WAIT_S)) == StatusCode.DEADLINE_EXCEEDED:
                pass  # Python handles signals here.
        except BaseException:
            self._is_interrupted = True
            raise
        # Referred to before another thread, which sends, can find its memory idle.
        batch = self._in_flight[0].batch
        self._in_flight.popleft()
        if code:
            self._check(code)
        return batch

    def _saved(self, environments: Iterable[int]) -> list[bytes]:
        """Returns snapshots of environments."""
        indices = _structs.indices(environments)
        if len(set(indices.tolist())) < len(indices):
            raise InvalidArgumentError(f"environments is {indices.tolist()}; each is given once")
        offsets = np.zeros(len(indices) + 1, np.uintp)
        data = np.empty(4096 * len(indices), np.uint8)

        def save() -> int:
            code: int = self._library.save_states(
                *(self._handle, indices.ctypes.data, len(indices)),
                *(data.ctypes.data, len(data), offsets.ctypes.data),
            )
            # Too little room: the offsets are set.
            return 0 if int(offsets[-1]) > len(data) else code

        self._run(save)
        if int(offsets[-1]) > len(data):
            data = np.empty(int(offsets[-1]), np.uint8)
            self._run(save)
        bounds = offsets.tolist()
        return [data[begin:end].tobytes() for begin, end in zip(bounds[:-1], bounds[1:])]

    def _interrupt(self) -> None:
        """Has what is in flight discarded, as after an exception during a wait."""
        self._is_interrupted = bool(self._in_flight)

    def _discard(self) -> None:
        """Waits for what an interrupted wait left in flight, and drops it."""
        count = self._library.unanswered_count(self._handle)
        while count:
            code = self._library.receive(self._handle, _WAIT_S)
            before, count = count, self._library.unanswered_count(self._handle)
            if count == before and code != StatusCode.DEADLINE_EXCEEDED:
                break  # Such as in a forked child.
        self._in_flight.clear()
        self._is_interrupted = False

    def _call(self, function: Callable[..., int], *arguments: object) -> None:
        self._run(lambda: function(self._handle, *arguments))

    def _run(self, call: Callable[[], int]) -> None:
        """Calls the library, and raises the error of the code that it returns."""
        self._check_open()
        self._require_nothing_in_flight()
        if self.client is None:
            self._check(call())
        else:
            self.client._run(lambda: self._check_alone(call))

    def _check_alone(self, call: Callable[[], int]) -> None:
        with self._calls:
            self._check(call())

    def _check(self, code: int) -> None:
        if code:
            error = self._library.error(code)
            self._check_open()
            raise error

    def _check_open(self) -> None:
        if self.closed:
            raise FailedPreconditionError("the pool is closed: make another one")

    def _await_call(self) -> None:
        """Waits for a call that an exception left behind."""
        if self._calls.locked():
            with self._calls:
                pass

    def _require_nothing_in_flight(self) -> None:
        self._await_call()
        if self._is_interrupted:
            self._discard()
        if self._in_flight:
            raise FailedPreconditionError(
                f"{len(self._in_flight)} requests are unanswered: receive them first"
            )

    def _count_of(self, first_env: int, env_count: int | None) -> int:
        """Returns the number of environments of a slice, which must be one of the pool."""
        self._await_call()
        if self._is_interrupted:
            self._discard()
        if not 0 <= first_env < self.env_count:
            raise InvalidArgumentError(
                f"first_env is {first_env}; the pool has environments 0 ... {self.env_count - 1}"
            )
        if env_count is None:
            return self.env_count - first_env
        if not 1 <= env_count <= self.env_count - first_env:
            raise InvalidArgumentError(
                f"env_count is {env_count} from environment {first_env}; the pool has "
                f"{self.env_count} environments"
            )
        return env_count
