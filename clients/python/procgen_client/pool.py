"""A pool of environments, in this process or on a server."""

from __future__ import annotations

import ctypes
import threading
import weakref
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy.typing as npt

from procgen_client import _library, _structs
from procgen_client._place import Server, new_pool, server_client
from procgen_client._pool_states import States
from procgen_client._requests import ENV_COUNT_MAX, Reset, in_range
from procgen_client.batch import Batch
from procgen_client.errors import FailedPreconditionError
from procgen_client.options import (
    PoolOptions,
    check_names,
    checked_options,
    game_names,
    keywords_of,
)
from procgen_client.tools.art import Art

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from procgen_client.client import Client

# Steps of one environment that one call of the library may take: some 50 ms.
_STEPS_AT_ONCE_MAX = 20_000


class Pool(States):
    """N environments that are stepped together. A context manager: leaving it closes the pool.

    Each environment is at the first step of its first level::

        with Pool("coinrun", 64, distribution_mode="easy", num_levels=200) as pool:
            batch = pool.observe()
            while True:
                batch = pool.step(policy(batch.observations))

    :meth:`step` waits for its batch. :meth:`send_step` and :meth:`receive` let the program work
    meanwhile; requests are executed and answered in order, each once. Results are the same in this
    process and on any server. An exception during a wait (Ctrl-C) discards the answers in flight;
    their steps were taken.

    Threads: one at a time. Processes: in a forked child every call fails; make another pool there.
    Pickle and copy.deepcopy: the options and the states of all environments.

    Attributes:
        games: Names of games; environment i plays ``games[i % len(games)]``.
        env_count: Number of environments, N.
        autoreset_mode: "same_step", "next_step" or "disabled".
        options: The other options that were given, with the rand_seed that was drawn.
        observation_shape: Shape of one observation, ``(64, 64, 3)`` by default. A stack of k > 1
            frames adds a first axis: ``(4, 84, 84, 1)`` for four grayscale frames.
        num_threads: In this process: threads that step beside the caller.
        name: On a server: the pool's resource name, e.g. ``"pools/7"``. Else empty.
        client: On a server: the connection. Else None.
    """

    def __init__(
        self,
        games: str | Sequence[str],
        env_count: int = 64,
        *,
        server: Server = None,
        art: Art | None = None,
        autoreset_mode: str = "same_step",
        **options: Unpack[PoolOptions],
    ) -> None:
        """Makes the environments.

        Args:
            games, env_count: A game, or several, which alternate; number of environments, N.
            server: Address of a server ("host:50051", "unix:/run/procgen.sock"), a Client (which
                close leaves open) or a ServerProcess. None: the address in the variable
                PROCGEN_SERVER, else this process.
            art: Art of a pool in this process: a folder in upstream's layout; "procgen": that of
                the installed package `procgen`. None: the variable PROCGEN_ART, else this
                project's own. A server has chosen its own.
            autoreset_mode: After the step that ends an episode: "same_step" observes the next
                episode, "next_step" starts it with the next step, "disabled" needs a reset.
            **options: See options.PoolOptions.

        Raises:
            InvalidArgumentError: A value is out of range or not of the game, an option is unknown
                (UnknownOptionError), or `art` is given with a server.
            NotFoundError: There is no such game or art.
            ProcgenError: On a server: as Client, and its limits.
        """
        check_names(type(self).__name__, options, option_names())
        self.games = tuple(game_names(games))
        self.env_count = in_range("env_count", env_count, 1, ENV_COUNT_MAX)
        self.autoreset_mode, self._art = autoreset_mode, art
        checked = checked_options({**options, "autoreset_mode": autoreset_mode})
        self._server = server
        self.client, owned = server_client(server, art)
        try:
            self._library, self._handle = new_pool(
                self.client, self.games, self.env_count, checked, art
            )
            info = _library.PoolInfo(struct_size=ctypes.sizeof(_library.PoolInfo))
            self._library.check(self._library.pool_info(self._handle, ctypes.byref(info)))
        except BaseException:
            if owned is not None:
                owned.close()
            raise
        self._close_once = weakref.finalize(
            self, _close, self._library.pool_destroy, self._handle, owned
        )
        self.options: dict[str, Any] = {**options, "rand_seed": info.rand_seed}
        self.num_threads: int = info.num_threads
        self.observation_shape = tuple(info.observation_shape[: info.observation_rank])
        name = b"" if self.client is None else self._library.pool_name(self._handle)
        self.name: str = name.decode()
        super().__init__(self.env_count, self.observation_shape)

    def __repr__(self) -> str:
        """Returns e.g. ``<Pool: 64 x coinrun>``."""
        name = f" {self.name}" if self.name else ""
        return f"<Pool{name}: {self.env_count} x {','.join(self.games)}>"

    def __enter__(self) -> Pool:
        """Returns the pool itself."""
        return self

    def __exit__(self, *exception: object) -> None:
        """Closes the pool."""
        self.close()

    def __getstate__(self) -> dict[str, Any]:
        """Supports pickle and copy: arguments, and the states of all environments."""
        if self.client is not None and not isinstance(self._server, (str, type(None))):
            raise FailedPreconditionError(
                f"{self!r} has the connection of this process: to copy it, give server=ADDRESS"
            )
        arguments = {
            "games": self.games,
            "env_count": self.env_count,
            "server": None if self.client is None else self.client.address,
            "art": self._art,
            "autoreset_mode": self.autoreset_mode,
            **self.options,
        }
        return {"arguments": arguments, "states": self.save_states()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Makes the copy."""
        Pool.__init__(self, **state["arguments"])
        self.restore_states(state["states"])

    @property
    def in_flight(self) -> int:
        """Number of unanswered requests."""
        return 0 if self._is_interrupted else len(self._in_flight)

    def close(self) -> None:
        """Frees the environments, on a server also the pool's name. May be called again."""
        if self._calls.locked() and (closing := self._close_once.detach()) is not None:
            arguments = (self._calls, *closing[2])  # The pool must outlive the call.
            threading.Thread(target=_close_later, args=arguments, daemon=True).start()
        self._close_once()
        self._handle = ctypes.c_void_p()  # Which the library refuses.
        self._in_flight.clear()
        self._known.clear()

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
        annotations: Mapping[str, npt.ArrayLike] | None = None,
        out: Any = None,  # noqa: ANN401 - an array or tensor
    ) -> Batch:
        """Steps each environment of a slice (default: the whole pool).

        Args:
            actions: int [n], each in [-1, 15), one for each of the slice's n environments. -1 ends
                the episode without a move.
            first_env: Index of the slice's first environment.
            env_count: Number of environments of the slice, n. None: up to the pool's last.
            observe: False: no observations, which is many times faster.
            repeat_count: Number of times that the action is repeated, in [1, 1000]. Rewards are
                summed, and an environment stops when its episode ends.
            final_observations: Also the last observation of each episode that ends. Useful with
                autoreset_mode "same_step".
            next_levels: Level seeds by environment (index in the pool), for the next episodes.
            resets: Environments (indices in the pool, or Resets) that start a new episode instead
                of a step; their actions are ignored.
            annotations: Values by name, [n] or [n, k], for viewers of a pool on a server:
                ``{"value": values, "action_probabilities": probabilities}``. At most 16 names of
                64 bytes, and 64 values for each environment. In this process nobody sees them.
            out: Receives the observations, and becomes Batch.observations: writable, C-contiguous,
                uint8 [n, *F]. A numpy array, a torch tensor on the CPU (also in pinned memory), or
                a buffer.

        Raises:
            InvalidArgumentError: An argument is out of range or of a wrong length. Nothing was
                stepped.
            FailedPreconditionError: Requests are unanswered; or an ended episode is stepped
                (autoreset_mode "disabled").
            ProcgenError: Any other error of the server.
        """
        buffers, kept = self._step_request(
            actions, first_env, env_count, observe, repeat_count, final_observations, next_levels,
            resets, annotations, out,
        )  # fmt: skip
        if self.client is None and self._step.env_count * repeat_count <= _STEPS_AT_ONCE_MAX:
            code = self._library.step(self._handle, self._step_reference, buffers.reference)
            del kept
            if code:
                self._check(code)
            return buffers.batch
        self._require_nothing_in_flight()
        self._check(
            self._library.send_step(self._handle, self._step_reference, buffers.reference)
        )
        del kept
        self._in_flight.append(buffers)
        return self.receive()

    def observe(
        self,
        *,
        first_env: int = 0,
        env_count: int | None = None,
        observe: bool = True,
        out: Any = None,  # noqa: ANN401 - an array or tensor
    ) -> Batch:
        """Returns the current state of a slice (default: the whole pool) without stepping.

        A learner gets the first observations this way. Rewards and ends repeat those of the last
        step: do not add them up. Arguments and errors as :meth:`step`.
        """
        self._require_nothing_in_flight()
        self.send_observe(first_env=first_env, env_count=env_count, observe=observe, out=out)
        return self.receive()

    def reset(
        self,
        resets: Iterable[int | Reset] | None = None,
        *,
        first_env: int = 0,
        env_count: int | None = None,
        observe: bool = True,
        out: Any = None,  # noqa: ANN401 - an array or tensor
    ) -> Batch:
        """Starts new episodes in some environments of a slice and returns the slice's state.

        Args:
            resets: Environments (indices in the pool, or Resets), at least one, each at most once.
                None: all of the slice. The others do not change.
            first_env, env_count, observe, out: As step.

        Errors as :meth:`step`.
        """
        self._require_nothing_in_flight()
        self.send_reset(resets, first_env=first_env, env_count=env_count, observe=observe, out=out)
        return self.receive()

    # Stepping with requests sent ahead.

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
        annotations: Mapping[str, npt.ArrayLike] | None = None,
        out: Any = None,  # noqa: ANN401 - an array or tensor
    ) -> None:
        """Begins a step; :meth:`receive` returns its batch. Arguments as :meth:`step`.

        `out` is written until then.

        Raises:
            InvalidArgumentError: As step. Nothing was sent.
            FailedPreconditionError: On a server: too many requests are unanswered.
        """
        buffers, _kept = self._step_request(
            *(actions, first_env, env_count, observe, repeat_count, final_observations),
            *(next_levels, resets, annotations, out),
        )
        self._check(
            self._library.send_step(self._handle, self._step_reference, buffers.reference)
        )
        self._in_flight.append(buffers)

    def send_observe(
        self,
        *,
        first_env: int = 0,
        env_count: int | None = None,
        observe: bool = True,
        out: Any = None,  # noqa: ANN401 - an array or tensor
    ) -> None:
        """Begins :meth:`observe`; errors as :meth:`send_step`."""
        count = self._count_of(first_env, env_count)
        buffers = self._buffers(first_env, count, observe, False, out)
        self._check(
            self._library.send_observe(self._handle, first_env, count, buffers.reference)
        )
        self._in_flight.append(buffers)

    def send_reset(
        self,
        resets: Iterable[int | Reset] | None = None,
        *,
        first_env: int = 0,
        env_count: int | None = None,
        observe: bool = True,
        out: Any = None,  # noqa: ANN401 - an array or tensor
    ) -> None:
        """Begins :meth:`reset`; errors as :meth:`send_step`."""
        count = self._count_of(first_env, env_count)
        array = _structs.resets(range(first_env, first_env + count) if resets is None else resets)
        buffers = self._buffers(first_env, count, observe, False, out)
        self._check(
            self._library.send_reset(
                self._handle, first_env, count, array, len(array), buffers.reference
            )
        )
        self._in_flight.append(buffers)

    def receive(self) -> Batch:
        """Waits for the batch of the oldest unanswered request.

        Raises:
            FailedPreconditionError: No request is unanswered; or as step.
            ProcgenError: Any other error of the server.
        """
        return self._oldest()


def option_names() -> set[str]:
    """Returns the names of the arguments of Pool."""
    return keywords_of(Pool.__init__) | set(PoolOptions.__annotations__)


def _close(
    destroy: Callable[[ctypes.c_void_p], None], handle: ctypes.c_void_p, client: Client | None
) -> None:
    destroy(handle)
    if client is not None:
        client.close()


def _close_later(
    calls: threading.Lock,
    destroy: Callable[[ctypes.c_void_p], None],
    handle: ctypes.c_void_p,
    client: Client | None,
) -> None:
    """As _close, once the call that holds `calls` has ended, which the end of a client causes."""
    if client is not None:
        client.close()
    with calls:
        _close(destroy, handle, client)
