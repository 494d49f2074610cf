"""A pool of environments that the engine steps in this process."""

from __future__ import annotations

import ctypes
import weakref
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from procgen_client import _library
from procgen_client._engine_batch import Buffers, EngineBatch
from procgen_client._engine_options import indices_of, next_level_array, reset_array, sampler_struct
from procgen_client._requests import ACTION_COUNT, ACTION_MIN, Reset
from procgen_client.errors import FailedPreconditionError, InvalidArgumentError
from procgen_client.options import LevelSampler

# Longest wait inside the library, so that a signal such as Ctrl-C is handled soon, in seconds.
_WAIT_S = 0.05
_DEADLINE_EXCEEDED = 4


class EnginePool:
    """N environments in this process. Threads: one at a time.

    Attributes:
        env_count: Number of environments, N.
        observation_shape: Shape of one observation, ``(64, 64, 3)`` by default.
        rand_seed: Seed of the choice of levels, given or drawn.
        num_threads: Threads that step beside the caller.
    """

    def __init__(self, options: _library.PoolOptions) -> None:
        """Makes the pool.

        Raises:
            InvalidArgumentError, NotFoundError: An option is out of range.
        """
        self._library = _library.library()
        handle = ctypes.c_void_p()
        code = self._library.pool_create(ctypes.byref(options), ctypes.byref(handle))
        if code:
            raise self._library.error(code)
        self._handle = handle
        self._close_once = weakref.finalize(self, self._library.pool_destroy, handle)
        info = _library.PoolInfo(struct_size=ctypes.sizeof(_library.PoolInfo))
        self._check(self._library.pool_info(handle, ctypes.byref(info)))
        self.env_count: int = info.env_count
        self.rand_seed: int = info.rand_seed
        self.num_threads: int = info.num_threads
        self.observation_shape = tuple(info.observation_shape[: info.observation_rank])
        # The next step, and the memory of its actions.
        self._actions = np.zeros(self.env_count, np.int32)
        self._step = _library.Step(struct_size=ctypes.sizeof(_library.Step))
        self._step.actions = self._actions.ctypes.data
        self._step_reference = ctypes.byref(self._step)
        self._idle: dict[tuple[int, bool, bool], list[Buffers]] = {}
        self._in_flight: list[Buffers] = []

    @property
    def closed(self) -> bool:
        """Whether close was called."""
        return not self._close_once.alive

    @property
    def in_flight(self) -> int:
        """Number of unanswered requests."""
        return len(self._in_flight)

    def close(self) -> None:
        """Frees the environments. Closing again does nothing."""
        self._close_once()
        self._handle = ctypes.c_void_p()  # Which the library refuses.
        self._in_flight.clear()

    # Stepping.

    def step(
        self,
        actions: npt.ArrayLike,
        *,
        first_env: int = 0,
        env_count: int | None = None,
        observe: bool = True,
        repeat_count: int = 1,
        final_observations: bool = False,
        next_levels: Mapping[int, int] | None = None,
        resets: Iterable[int | Reset] = (),
    ) -> EngineBatch:
        """Steps a slice (default: the whole pool).

        Args:
            actions: int [n], each in [0, 15), or -1, which ends the episode.
            first_env, env_count: The slice. None: up to the pool's last environment.
            observe: False: no observations, which is many times faster.
            repeat_count: How often each action is taken, in [1, 1000]. Rewards are summed.
            final_observations: Also the last observation of each episode that ends.
            next_levels: Level seeds by environment, for the next episodes.
            resets: Environments that start a new episode in place of a step.

        Raises:
            InvalidArgumentError: An argument has a wrong length or is out of range. Nothing was
                stepped.
            FailedPreconditionError: Requests are unanswered; or an ended episode is stepped
                (autoreset_mode "disabled").
        """
        buffers = self._prepare(
            actions, first_env, env_count, observe, repeat_count, final_observations
        )
        kept = self._set_sparse(next_levels, resets)
        code = self._library.step(self._handle, self._step_reference, buffers.reference)
        del kept
        if code:
            raise self._library.error(code)
        return buffers.batch

    def send_step(
        self,
        actions: npt.ArrayLike,
        *,
        first_env: int = 0,
        env_count: int | None = None,
        observe: bool = True,
        repeat_count: int = 1,
        final_observations: bool = False,
        next_levels: Mapping[int, int] | None = None,
        resets: Iterable[int | Reset] = (),
    ) -> None:
        """Begins a step, which :meth:`receive` ends; arguments as :meth:`step`.

        Several requests may be sent ahead; they are executed in order.

        Raises:
            InvalidArgumentError: As step. Nothing was sent.
        """
        buffers = self._prepare(
            actions, first_env, env_count, observe, repeat_count, final_observations
        )
        kept = self._set_sparse(next_levels, resets)
        code = self._library.send_step(self._handle, self._step_reference, buffers.reference)
        del kept
        if code:
            raise self._library.error(code)
        self._in_flight.append(buffers)

    def receive(self) -> EngineBatch:
        """Waits for the oldest unanswered request.

        Raises:
            FailedPreconditionError: No request is unanswered; or as step.
        """
        if not self._in_flight:
            raise FailedPreconditionError("no request is unanswered: send one first")
        while (code := self._library.receive(self._handle, _WAIT_S)) == _DEADLINE_EXCEEDED:
            pass  # Python handles signals here.
        buffers = self._in_flight.pop(0)
        if code:
            raise self._library.error(code)
        return buffers.batch

    def observe(
        self, *, first_env: int = 0, env_count: int | None = None, observe: bool = True
    ) -> EngineBatch:
        """Returns the current values of a slice without stepping; errors as :meth:`step`."""
        count = self._count_of(first_env, env_count)
        buffers = self._buffers(first_env, count, observe, final=False)
        self._check(self._library.observe(self._handle, first_env, count, buffers.reference))
        return buffers.batch

    def reset(
        self,
        resets: Iterable[int | Reset] | None = None,
        *,
        first_env: int = 0,
        env_count: int | None = None,
        observe: bool = True,
    ) -> EngineBatch:
        """Starts new episodes in some environments of a slice; returns the slice's values.

        Args:
            resets: Environments (indices in the pool, or Resets), each at most once. None: all.
            first_env, env_count, observe: As step.

        Errors as :meth:`step`.
        """
        count = self._count_of(first_env, env_count)
        array = reset_array(range(first_env, first_env + count) if resets is None else resets)
        buffers = self._buffers(first_env, count, observe, final=False)
        code = self._library.reset(
            self._handle, first_env, count, array, len(array), buffers.reference
        )
        self._check(code)
        return buffers.batch

    def set_level_sampler(self, level_sampler: LevelSampler) -> None:
        """Replaces the level sampler, from each environment's next choice of a level."""
        struct, kept = sampler_struct(level_sampler)
        self._check(self._library.set_level_sampler(self._handle, ctypes.byref(struct)))
        del kept

    # States.

    def save_states(self, environments: Sequence[int] | None = None) -> list[bytes]:
        """Returns snapshots of environments (None: all), for any pool of the same game.

        Raises:
            InvalidArgumentError: An environment is out of range.
            FailedPreconditionError: Requests are unanswered.
        """
        indices = indices_of(range(self.env_count) if environments is None else environments)
        offsets = np.zeros(len(indices) + 1, np.uintp)
        data = np.empty(4096 * len(indices), np.uint8)
        while True:
            code = self._library.save_states(
                self._handle, indices.ctypes.data, len(indices), data.ctypes.data, len(data),
                offsets.ctypes.data,
            )  # fmt: skip
            if not code or offsets[-1] <= len(data):
                self._check(code)
                break
            data = np.empty(int(offsets[-1]), np.uint8)
        bounds = offsets.tolist()
        return [
            data[begin:end].tobytes() for begin, end in zip(bounds[:-1], bounds[1:], strict=True)
        ]

    def restore_states(self, states: Mapping[int, bytes] | Sequence[bytes]) -> None:
        """Restores environments: by index, or a list for all. All or nothing.

        Raises:
            InvalidArgumentError: An environment is out of range, or a list has another length.
            FailedPreconditionError: A snapshot is of another game, or requests are unanswered.
            DataLossError: A snapshot is damaged or of another version.
        """
        if not isinstance(states, Mapping):
            if len(states) != self.env_count:
                raise InvalidArgumentError(
                    f"states has {len(states)} snapshots; the pool has {self.env_count} "
                    "environments"
                )
            states = dict(enumerate(states))
        indices = indices_of(states)
        offsets = np.zeros(len(indices) + 1, np.uintp)
        offsets[1:] = np.cumsum([len(state) for state in states.values()])
        data = b"".join(states.values())
        self._check(
            self._library.restore_states(
                self._handle, indices.ctypes.data, len(indices), data, offsets.ctypes.data
            )
        )

    def clone_states(self, sources: Sequence[int], targets: Sequence[int]) -> None:
        """Copies states within the pool: sources[i] to targets[i]. All or nothing.

        Raises:
            InvalidArgumentError: An index is out of range, or a target is named twice.
            FailedPreconditionError: The games differ, or requests are unanswered.
        """
        origins, places = indices_of(sources), indices_of(targets)
        if len(origins) != len(places):
            raise InvalidArgumentError(f"{len(origins)} sources, but {len(places)} targets")
        self._check(
            self._library.clone_states(
                self._handle, origins.ctypes.data, places.ctypes.data, len(origins)
            )
        )

    def render(
        self,
        environments: Sequence[int] | None = None,
        *,
        size_px: int = 512,
        whole_level: bool = False,
    ) -> list[np.ndarray]:
        """Draws environments for people: uint8 [size_px, size_px, 3] each; None: all.

        Raises:
            InvalidArgumentError: An environment or the size is out of range.
            FailedPreconditionError: Requests are unanswered.
        """
        frames = []
        for environment in range(self.env_count) if environments is None else environments:
            side = max(int(size_px), 0)
            frame = np.empty((side, side, 3), np.uint8)
            code = self._library.render(
                self._handle, environment, size_px, whole_level, frame.ctypes.data
            )
            self._check(code)
            frames.append(frame)
        return frames

    # Internals.

    def _check(self, code: int) -> None:
        if code:
            error = self._library.error(code)
            self._check_open()
            raise error

    def _check_open(self) -> None:
        if self.closed:
            raise FailedPreconditionError("the pool is closed")

    def _count_of(self, first_env: int, env_count: int | None) -> int:
        self._check_open()
        return self.env_count - first_env if env_count is None else env_count

    def _prepare(
        self,
        actions: npt.ArrayLike,
        first_env: int,
        env_count: int | None,
        observe: bool,
        repeat_count: int,
        final: bool,
    ) -> Buffers:
        """Fills the struct of the next step and returns memory for its values."""
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
        self._step.first_env, self._step.env_count = first_env, count
        self._step.repeat_count = repeat_count
        return self._buffers(first_env, count, observe, final)

    def _set_sparse(
        self, next_levels: Mapping[int, int] | None, resets: Iterable[int | Reset]
    ) -> object:
        """Sets the lists of the next step; returns what must live until it was sent."""
        if not next_levels and resets == ():
            self._step.next_level_count = self._step.reset_count = 0
            return None
        next_array = next_level_array(next_levels or {})
        array = reset_array(resets)
        self._step.next_levels, self._step.next_level_count = next_array, len(next_array)
        self._step.resets, self._step.reset_count = array, len(array)
        return next_array, array

    def _buffers(self, first_env: int, count: int, observe: bool, final: bool) -> Buffers:
        """Returns memory that nobody refers to: of an earlier batch, or new."""
        key = (count, observe, final)
        known = self._idle.setdefault(key, [])
        for buffers in known:
            if buffers.is_idle() and buffers not in self._in_flight:
                break
        else:
            if count < 1 or count > self.env_count:
                raise InvalidArgumentError(
                    f"env_count is {count}; the pool has {self.env_count} environments"
                )
            buffers = Buffers(count, self.observation_shape, observe, final)
            # A learner that keeps its batches gets new memory each time.
            known.append(buffers)
            del known[:-_KEPT_BUFFERS]
        buffers.batch.first_env = first_env
        return buffers


# Batches whose memory is used again, of one size.
_KEPT_BUFFERS = 4
