"""A pool as it lies on a server: what can be asked of it from beside its stream."""

from __future__ import annotations

import abc
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from google.protobuf import empty_pb2

from procgen_client._proto import pools_pb2, render_pb2, states_pb2
from procgen_client._requests import clone_pair_messages, in_range, message_of, state_messages
from procgen_client.errors import InvalidArgumentError
from procgen_client.options import duration

if TYPE_CHECKING:
    from procgen_client.client import Client

# What a server sends at most in one response unless told otherwise. In bytes.
RESPONSE_BYTES_DEFAULT = 4 * 1024 * 1024
# What a response of frames has besides their pixels, at most: once, and for each. In bytes.
_FRAMES_OVERHEAD_BYTES = 4096
_FRAME_OVERHEAD_BYTES = 64
# Which episode, by its name here.
_EPISODE_SELECTORS = {
    "last": states_pb2.EPISODE_SELECTOR_LAST,
    "current": states_pb2.EPISODE_SELECTOR_CURRENT,
}


class PoolResource(abc.ABC):
    """What a pool is, and the calls that need no stream: snapshots and pictures for people.

    They happen between two requests of whoever steps the pool. :class:`Pool` adds the stream.

    Threads: one at a time.

    Attributes:
        name: Resource name, e.g. ``"pools/7"``.
        spec: What the pool was made with, every default filled in (also a rand_seed that the server
            drew).
        env_count: Number of environments, N.
        observation_shape: Shape of one environment's observation, ``(64, 64, 3)`` by default; with
            a stack of k > 1 pictures k comes first, so ``(4, 84, 84, 1)`` for four grey ones.
    """

    def __init__(self, client: Client, message: pools_pb2.Pool) -> None:
        """For :class:`Pool`."""
        self._message = message
        self.name = message.name
        self.spec = message.spec
        self.env_count = message.spec.env_count
        self.observation_shape = tuple(message.observation_shape)
        self._client = client

    # Saving and restoring.

    def save_states(self, environments: Sequence[int] | None = None) -> list[bytes]:
        """Takes snapshots of environments and changes nothing.

        A snapshot is complete: an environment that is put into it goes on as this one does, bit for
        bit, in any pool of the same game on any server.

        Args:
            environments: Indices in the pool, in the order wanted, each at most once. None: all.

        Returns:
            A snapshot of each, 1 to 12 kilobytes; to be stored and given back as it is.

        Raises:
            InvalidArgumentError: An environment is out of range or named twice.
            FailedPreconditionError: Answers of requests sent before were not received.
            AbortedError: Somebody else stepped the pool meanwhile.
        """
        self._require_nothing_in_flight()
        if environments is not None and len(environments) == 0:
            return []
        request = message_of(
            states_pb2.SaveStatesRequest, pool=self.name, environments=environments
        )
        response = self._client._call("SaveStates", request, states_pb2.SaveStatesResponse)
        return [state.snapshot for state in response.states]

    def restore_states(self, states: Mapping[int, bytes] | Sequence[bytes]) -> None:
        """Puts environments into saved states.

        Their options (mode, levels, looks) and their choice of levels come from the snapshots; what
        follows the end of an episode stays as the pool was made with. :meth:`observe` tells how
        they stand then, which is as they stood when they were saved.

        All or nothing, as long as the snapshots fit one request of the server
        (``catalog().limits.request_bytes_max``, 4 MiB unless it was told otherwise). More are sent
        in several, and those before one that is refused are restored.

        Args:
            states: Snapshots by environment (index in the pool); or a list of env_count of them,
                one for each environment.

        Raises:
            InvalidArgumentError: An environment is out of range, a list has a wrong length, or a
                snapshot holds what it cannot.
            FailedPreconditionError: A snapshot is of another game than the environment's; or
                answers of requests sent before were not received.
            DataLossError: A snapshot is damaged, or of another version.
        """
        self._require_nothing_in_flight()
        messages = state_messages(states, self.env_count)
        if messages:
            request = states_pb2.RestoreStatesRequest(pool=self.name, states=messages)
            self._client._call("RestoreStates", request, empty_pb2.Empty)

    def clone_states(
        self,
        pairs: Iterable[tuple[int, int]],
        *,
        source_pool: PoolResource | str | None = None,
        source_server: str | None = None,
    ) -> None:
        """Puts environments of this pool into the states of others.

        As save_states and restore_states, but the snapshots do not travel by way of this client.
        All or nothing; all are read before any is written, so states can be exchanged.

        Args:
            pairs: (source, target): indices of the environment that is read, in source_pool, and of
                the one that is written, in this pool. Each target at most once.
            source_pool: The pool that is read, or its name. None: this one (on another server: the
                one of the same name).
            source_server: Address of the server of source_pool, as this pool's server can reach it.
                None: the same server.

        Raises:
            InvalidArgumentError: An environment is out of range, or a target is named twice.
            NotFoundError: There is no such source_pool.
            FailedPreconditionError: The environments play different games; or answers of requests
                sent before were not received.
            UnavailableError: source_server cannot be reached.
        """
        self._require_nothing_in_flight()
        messages = clone_pair_messages(pairs)
        if not messages:
            return
        source_name = source_pool.name if isinstance(source_pool, PoolResource) else source_pool
        request = states_pb2.CloneStatesRequest(
            pool=self.name,
            source_pool=source_name,
            source_server=source_server,
            pairs=messages,
        )
        self._client._call("CloneStates", request, empty_pb2.Empty)

    def get_episode(self, environment: int, selector: str = "last") -> states_pb2.Episode:
        """Returns an episode of an environment, with all that is needed to replay it.

        Args:
            environment: Index in the pool.
            selector: "last", the last episode that ended, or "current", the one under way.

        Returns:
            The message of proto/procgen/v1/states.proto, whose comments describe its fields (game,
            options, level_seed, actions, rewards, how it ended) and how it is played again.

        Raises:
            InvalidArgumentError: The environment is out of range, or there is no such `selector`.
            FailedPreconditionError: No episode has ended yet, or the next has not begun.
            UnimplementedError: The server remembers no episodes.
        """
        if selector not in _EPISODE_SELECTORS:
            raise InvalidArgumentError(f'selector is {selector!r}; it is "last" or "current"')
        request = message_of(
            states_pb2.GetEpisodeRequest,
            pool=self.name,
            environment=environment,
            selector=_EPISODE_SELECTORS[selector],
        )
        return self._client._call("GetEpisode", request, states_pb2.Episode)

    # The lease.

    def renew(self, lease_duration: float | None = None) -> None:
        """Restarts the pool's lease: its time to live while no stream is attached.

        Args:
            lease_duration: Its length from now on, in seconds; also of a pool that had none. None:
                it stays as it is.

        Raises:
            InvalidArgumentError: It is shorter than a second.
            ResourceExhaustedError: It is longer than the server allows.
            NotFoundError: The pool is gone; its lease may have run out.
        """
        length = None if lease_duration is None else duration(lease_duration)
        request = pools_pb2.RenewPoolRequest(name=self.name, lease_duration=length)
        self._client._call("RenewPool", request, pools_pb2.Pool)

    # Looking.

    def render(
        self, environments: Sequence[int] | None = None, *, size_px: int = 512
    ) -> list[np.ndarray]:
        """Draws environments for people and changes nothing.

        Args:
            environments: Indices in the pool, in the order wanted. None: all.
            size_px: Side of the square pictures in pixels, in [16, 2048].

        Returns:
            uint8 arrays [size_px, size_px, 3] (red, green, blue; top row first), read-only.

        Raises:
            InvalidArgumentError: An environment or the size is out of range.
            UnimplementedError: The server does not draw for people (catalog().features.render).
        """
        wanted = list(range(self.env_count)) if environments is None else list(environments)
        frame_bytes = _frame_bytes(size_px)
        limit = min(RESPONSE_BYTES_DEFAULT, self._client.catalog().limits.response_bytes_max)
        at_a_time = max(1, (limit - _FRAMES_OVERHEAD_BYTES) // frame_bytes)
        frames: list[np.ndarray] = []
        for begin in range(0, len(wanted), at_a_time):
            request = self._frames_request(
                render_pb2.RenderEnvironmentsRequest, wanted[begin : begin + at_a_time], size_px
            )
            rendered = self._client._call(
                "RenderEnvironments", request, render_pb2.RenderEnvironmentsResponse
            )
            frames += [_pixels_of(frame) for frame in rendered.frames]
        return frames

    def watch(
        self,
        environments: Sequence[int] | None = None,
        *,
        size_px: int = 256,
        frames_per_second_max: float = 15.0,
    ) -> Iterator[list[np.ndarray]]:
        """Yields frames of environments while the pool is stepped, without slowing it down.

        At first as they are now, then as they are after something has changed, at a bounded rate:
        whoever takes long between two moments misses those in between. Ends with an error, or when
        it is closed; breaking out of a loop over it closes it.

        Args:
            environments: Indices in the pool, in the order wanted, at most 64. None: the first 16.
            size_px: Side of the square pictures in pixels, in [16, 2048]. 64: what the agent sees.
            frames_per_second_max: Moments in a second at most, above 0 and at most 60.

        Yields:
            For each moment, arrays as those of :meth:`render`.

        Raises:
            InvalidArgumentError: An environment, the size or the rate is out of range.
            ResourceExhaustedError: The pictures of a moment are more than the server sends
                (``catalog().limits.response_bytes_max``), or too much is watched at a time
                (``catalog().limits.owner_watch_count_max``).
            AbortedError: The pool is gone.
            UnavailableError: The server drains, or the connection broke.
        """
        wanted = range(min(self.env_count, 16)) if environments is None else environments
        request = self._frames_request(
            render_pb2.WatchPoolRequest,
            list(wanted),
            size_px,
            frames_per_second_max=frames_per_second_max,
        )
        for moment in self._client._watch("WatchPool", request, render_pb2.WatchPoolResponse):
            yield [_pixels_of(frame) for frame in moment.frames]

    def _frames_request(
        self,
        cls: Any,  # noqa: ANN401
        environments: list[int],
        size_px: int,
        **fields: Any,  # noqa: ANN401
    ) -> Any:  # noqa: ANN401
        """Gives a request for frames; errors as :meth:`render`."""
        frames_bytes = _FRAMES_OVERHEAD_BYTES + len(environments) * _frame_bytes(size_px)
        return message_of(
            cls,
            pool=self.name,
            environments=environments,
            size_px=size_px,
            format=render_pb2.FRAME_FORMAT_RGB,
            # No more than they take, as a server may have a low limit. 0: what it sends by default.
            response_bytes_max=0 if frames_bytes <= RESPONSE_BYTES_DEFAULT else frames_bytes,
            **fields,
        )

    @abc.abstractmethod
    def _require_nothing_in_flight(self) -> None:
        """Raises FailedPreconditionError where requests are unanswered."""


def _frame_bytes(size_px: int) -> int:
    return 3 * in_range("size_px", size_px, 16, 2048) ** 2 + _FRAME_OVERHEAD_BYTES


def _pixels_of(frame: render_pb2.Frame) -> np.ndarray:
    pixels = np.frombuffer(frame.image, np.uint8)
    return pixels.reshape(frame.size_px, frame.size_px, 3)
