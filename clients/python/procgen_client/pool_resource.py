"""The calls on a pool that need no stream: snapshots, episodes, the lease, frames."""

from __future__ import annotations

import abc
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from google.protobuf import empty_pb2

from procgen_client._proto import pools_pb2, render_pb2, states_pb2
from procgen_client._requests import clone_pair_messages, in_range, message_of, state_messages
from procgen_client.errors import DataLossError, InvalidArgumentError
from procgen_client.options import duration

if TYPE_CHECKING:
    from procgen_client.client import Client

# A server's default limit of one response, in bytes.
RESPONSE_BYTES_DEFAULT = 4 * 1024 * 1024
# Upper bounds of a response of frames without pixels: per response and per frame, in bytes.
_FRAMES_OVERHEAD_BYTES = 4096
_FRAME_OVERHEAD_BYTES = 64
# Episode selectors by their names in this package.
_EPISODE_SELECTORS = {
    "last": states_pb2.EPISODE_SELECTOR_LAST,
    "current": states_pb2.EPISODE_SELECTOR_CURRENT,
}


class PoolResource(abc.ABC):
    """A pool and the calls that need no stream. :class:`Pool` adds the stream.

    The server executes them between two requests of the pool's learner.

    Threads: one at a time.

    Attributes:
        name: Resource name, e.g. ``"pools/7"``.
        spec: The pool's specification with all defaults, including a rand_seed that the server
            drew.
        env_count: Number of environments, N.
        observation_shape: Shape of one observation, ``(64, 64, 3)`` by default. A stack of k > 1
            frames adds a first axis: ``(4, 84, 84, 1)`` for four grayscale frames.
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
        """Returns snapshots of environments; the environments do not change.

        A snapshot is complete: an environment restored from it continues as this one does, bit for
        bit, in any pool of the same game on any server.

        Args:
            environments: Indices in the pool, in any order, each at most once. None: all.

        Returns:
            A snapshot of each, of 1 to 26 kB, in the order of `environments`.

        Raises:
            InvalidArgumentError: An environment is out of range or given twice.
            FailedPreconditionError: Requests of this object are unanswered.
            AbortedError: Another client stepped the pool during the call.
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
        """Restores environments from snapshots.

        Options (mode, levels, appearance) and the choice of levels come from the snapshots; the
        autoreset mode remains the pool's. :meth:`Pool.observe` then returns what it returned when
        the snapshots were taken.

        All or nothing, if the snapshots fit one request of the server
        (``catalog().limits.request_bytes_max``, 4 MiB by default). More are sent in several
        requests; those before a rejected one are restored.

        Args:
            states: Snapshots by environment (index in the pool), or a list with one for each
                environment.

        Raises:
            InvalidArgumentError: An environment is out of range, a list has a wrong length, or a
                snapshot contains an impossible value.
            FailedPreconditionError: A snapshot is of another game than the environment's; or
                requests of this object are unanswered.
            DataLossError: A snapshot is damaged or of another version.
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
        """Copies states of environments to environments of this pool.

        Like save_states and restore_states, but the snapshots do not pass through this client. All
        or nothing. All sources are read before any target is written, so states can be exchanged.

        Args:
            pairs: (source, target): index in source_pool, index in this pool. Each target at most
                once.
            source_pool: The pool that is read, or its name. None: this one (on another server: the
                pool of the same name).
            source_server: Address of the server of source_pool, as this pool's server can reach it.
                None: the same server.

        Raises:
            InvalidArgumentError: An environment is out of range, or a target is given twice.
            NotFoundError: There is no such source_pool.
            FailedPreconditionError: The environments play different games; or requests of this
                object are unanswered.
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
        """Returns an episode of an environment, with everything that a replay needs.

        Args:
            environment: Index in the pool.
            selector: "last", the last episode that ended, or "current", the running one.

        Returns:
            The message Episode of proto/procgen/v1/states.proto, which documents its fields (game,
            options, level_seed, actions, rewards, end) and how to replay it.

        Raises:
            InvalidArgumentError: The environment is out of range, or there is no such `selector`.
            FailedPreconditionError: No episode has ended yet, or the next has not begun.
            UnimplementedError: The server keeps no episodes.
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

    def find_episode(self, environment: int, fingerprint: int) -> states_pb2.Episode:
        """Returns an episode that ended, as :meth:`get_episode`, by its fingerprint.

        Args:
            environment: Index in the pool.
            fingerprint: An element of Batch.fingerprints: those of the environments where
                Batch.ended is true, in order. Not 0.

        Raises:
            InvalidArgumentError: The environment or the fingerprint is out of range.
            NotFoundError: The server has not this episode, or not any more: it has those of a
                pool's last 1,000, or fewer if they are long.
        """
        value = in_range("fingerprint", int(fingerprint), 1, 2**64 - 1)
        request = message_of(
            states_pb2.GetEpisodeRequest,
            pool=self.name,
            environment=environment,
            fingerprint=value if value < 2**63 else value - 2**64,  # int64 in the message
        )
        return self._client._call("GetEpisode", request, states_pb2.Episode)

    # The lease.

    def renew(self, lease_duration: float | None = None) -> None:
        """Restarts the pool's lease: its time to live while no stream is attached.

        Args:
            lease_duration: The new length in seconds, also for a pool without a lease. None:
                unchanged.

        Raises:
            InvalidArgumentError: It is shorter than a second.
            ResourceExhaustedError: It is longer than the server allows.
            NotFoundError: The pool does not exist any more; its lease may have expired.
        """
        length = None if lease_duration is None else duration(lease_duration)
        request = pools_pb2.RenewPoolRequest(name=self.name, lease_duration=length)
        self._client._call("RenewPool", request, pools_pb2.Pool)

    # Frames.

    def render(
        self,
        environments: Sequence[int] | None = None,
        *,
        size_px: int = 512,
        whole_level: bool = False,
    ) -> list[np.ndarray]:
        """Renders environments for people; the environments do not change.

        Args:
            environments: Indices in the pool, in any order. None: all.
            size_px: Side of the square frames in pixels, in [16, 2048].
            whole_level: Whether to show the whole level instead of the agent's surroundings.

        Returns:
            uint8 arrays [size_px, size_px, 3] (RGB, top row first), read-only, in the order of
            `environments`.

        Raises:
            InvalidArgumentError: An environment or the size is out of range.
            UnimplementedError: The server has no rendering (catalog().features.render).
        """
        view = render_pb2.FRAME_VIEW_LEVEL if whole_level else render_pb2.FRAME_VIEW_HUMAN
        wanted = list(range(self.env_count)) if environments is None else list(environments)
        frame_bytes = _frame_bytes(size_px)
        limit = min(RESPONSE_BYTES_DEFAULT, self._client.catalog().limits.response_bytes_max)
        at_a_time = max(1, (limit - _FRAMES_OVERHEAD_BYTES) // frame_bytes)
        frames: list[np.ndarray] = []
        for begin in range(0, len(wanted), at_a_time):
            request = self._frames_request(
                render_pb2.RenderEnvironmentsRequest,
                wanted[begin : begin + at_a_time],
                size_px,
                view=view,
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

        The first frames are the current ones, the next follow after changes, at a bounded rate. The
        last state of an episode is shown once, before the start of the next. A slow reader skips
        intermediate frames. The iteration ends with an error or when it is
        closed; breaking out of a loop closes it.

        Args:
            environments: Indices in the pool, in any order, at most 64. None: the first 16.
            size_px: Side of the square frames in pixels, in [16, 2048]. 64: the agent's
                observation.
            frames_per_second_max: Upper bound of the rate, above 0 and at most 60.

        Yields:
            A frame of each environment, as :meth:`render` returns them.

        Raises:
            InvalidArgumentError: An environment, the size or the rate is out of range.
            ResourceExhaustedError: The frames are larger than a response of the server
                (``catalog().limits.response_bytes_max``), or the caller watches too much
                (``catalog().limits.owner_watch_count_max``).
            AbortedError: The pool was deleted.
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
        """Returns a request for frames; errors as :meth:`render`."""
        frames_bytes = _FRAMES_OVERHEAD_BYTES + len(environments) * _frame_bytes(size_px)
        return message_of(
            cls,
            pool=self.name,
            environments=environments,
            size_px=size_px,
            format=render_pb2.FRAME_FORMAT_RGB,
            # Not more than needed, since a server may have a low limit. 0: the server's default.
            response_bytes_max=0 if frames_bytes <= RESPONSE_BYTES_DEFAULT else frames_bytes,
            **fields,
        )

    @abc.abstractmethod
    def _require_nothing_in_flight(self) -> None:
        """Raises FailedPreconditionError if requests are unanswered."""


def _frame_bytes(size_px: int) -> int:
    return 3 * in_range("size_px", size_px, 16, 2048) ** 2 + _FRAME_OVERHEAD_BYTES


def _pixels_of(frame: render_pb2.Frame) -> np.ndarray:
    pixels = np.frombuffer(frame.image, np.uint8)
    try:
        return pixels.reshape(frame.size_px, frame.size_px, 3)
    except ValueError as error:
        raise DataLossError(f"a frame of {frame.size_px} pixels: {error}") from None
