"""A connection to a server."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, Union

import numpy as np

try:
    import google.protobuf  # noqa: F401
except ImportError:  # The wheel has a copy.
    sys.path.append(str(Path(__file__).resolve().parent / "_vendor"))
from google.protobuf import message as protobuf_message

from procgen_client import _connection, _interruptible, _library
from procgen_client._proto import (
    catalog_pb2,
    cluster_pb2,
    episodes_pb2,
    pool_service_pb2,
    pools_pb2,
    render_pb2,
)
from procgen_client._requests import in_range
from procgen_client.credentials import Credentials
from procgen_client.errors import (
    FailedPreconditionError,
    InvalidArgumentError,
    UnauthenticatedError,
)
from procgen_client.options import PoolOptions, text
from procgen_client.pool import Pool

if TYPE_CHECKING:
    from typing_extensions import Unpack

_Message = TypeVar("_Message", bound=protobuf_message.Message)

# A pool by its object or its name.
PoolName = Union[Pool, str]
# Path of each method by its name.
_PATHS = {
    method.name: f"/{service.full_name}/{method.name}"
    for module in (catalog_pb2, cluster_pb2, pool_service_pb2)
    for service in module.DESCRIPTOR.services_by_name.values()
    for method in service.methods
}
# Episode selectors by their names in this package.
_EPISODE_SELECTORS = {
    "last": episodes_pb2.EPISODE_SELECTOR_LAST,
    "current": episodes_pb2.EPISODE_SELECTOR_CURRENT,
}


class Client:
    """A connection to a server, for pools there and for what the server says of any pool.

    A context manager: leaving it closes the connection, which ends its pools.

    Threads: any method from any thread; a :class:`Pool` belongs to one thread at a time.

    Processes: it belongs to the process that made it. In a forked child its calls and those of its
    pools raise FailedPreconditionError; a process that is to have clients of its own is started
    with ``multiprocessing.get_context("spawn")``.

    Attributes:
        address: Address of the server.
        reconnect_timeout: Seconds for which pools try to continue after a broken connection.
    """

    def __init__(
        self,
        address: str,
        *,
        timeout: float | None = None,
        call_timeout: float = 60.0,
        reconnect_timeout: float = 60.0,
        credentials: Credentials | None = None,
    ) -> None:
        """Connects.

        Args:
            address: ``"localhost:50051"``, ``"unix:/run/procgen.sock"`` or another gRPC target; or
                several, separated by commas, which share each pool. A host name with several IPv4
                addresses stands for as many servers, ``"cluster:HOST:PORT"`` for all of a cluster.
            timeout: Time to wait for the server, in seconds; it may still be starting. None: 10, or
                1.5 if nothing listens at the address.
            call_timeout: Time limit of each call other than steps, in seconds.
            reconnect_timeout: Time for which a pool tries to continue after a broken connection, in
                seconds. 0: a broken connection ends the pool.
            credentials: TLS certificates and token. None: those of the environment variables
                (Credentials.from_environment).

        Raises:
            UnavailableError: No server listens or answers in time; or, at once, it requires TLS,
                has none, or its certificate is not valid for `credentials`. The message has the
                reason.
            UnauthenticatedError: The server requires a token, or another one.
            InvalidArgumentError, NotFoundError: `address` has no port; or `credentials`
                are incomplete, or would send a token to another machine in plain text.
            UnimplementedError: The address belongs to another kind of server.
            FailedPreconditionError: This process was forked from one that has connections.
            OSError: libprocgen_remote is not installed.
        """
        self.address = text("address", address)
        self.reconnect_timeout = reconnect_timeout
        self._closed = False
        self._process_id = os.getpid()
        shown = Credentials.from_environment() if credentials is None else credentials
        options = {
            "timeout_s": -1.0 if timeout is None else timeout,
            "call_timeout_s": call_timeout,
            "reconnect_timeout_s": reconnect_timeout,
            **shown.arguments(),
        }
        try:
            self._connection = _connection.Connection(_library.remote_library(), address, options)
            try:
                self._catalog = self._call(
                    "GetCatalog", catalog_pb2.GetCatalogRequest(), catalog_pb2.Catalog
                )
            except BaseException:
                self.close()
                raise
        except UnauthenticatedError as error:
            hint = "set PROCGEN_SERVER_TOKEN, or give credentials=Credentials(token=...)"
            raise UnauthenticatedError(f"{error.message} ({hint})") from None

    def __repr__(self) -> str:
        """Returns e.g. ``<Client of localhost:50051>``."""
        return f"<Client of {self.address}{' (closed)' if self._closed else ''}>"

    def __enter__(self) -> Client:
        """Returns the client itself."""
        return self

    def __exit__(self, *exception: object) -> None:
        """Closes the connection."""
        self.close()

    @property
    def closed(self) -> bool:
        """Whether close was called."""
        return self._closed

    def close(self) -> None:
        """Closes the connection; running calls end with CancelledError. May be repeated."""
        self._closed = True
        if os.getpid() == self._process_id:
            self._connection.close()

    # Pools.

    def create_pool(
        self,
        games: str | Sequence[str],
        env_count: int = 64,
        *,
        autoreset_mode: str = "same_step",
        **options: Unpack[PoolOptions],
    ) -> Pool:
        """Returns ``Pool(games, env_count, server=self, ...)``."""
        return Pool(games, env_count, server=self, autoreset_mode=autoreset_mode, **options)

    def list_pools(self) -> list[pools_pb2.Pool]:
        """Returns the caller's pools, oldest first (proto/procgen/v1/pools.proto)."""
        pools: list[pools_pb2.Pool] = []
        request = pool_service_pb2.ListPoolsRequest()
        while True:
            page = self._call("ListPools", request, pool_service_pb2.ListPoolsResponse)
            pools += page.pools
            if not page.next_page_token:
                return pools
            request.page_token = page.next_page_token

    def get_pool(self, name: str) -> pools_pb2.Pool:
        """Returns a pool's specification and statistics (proto/procgen/v1/pools.proto).

        Raises:
            InvalidArgumentError: `name` is not of the form ``pools/{pool_id}``.
            NotFoundError: There is no such pool.
        """
        return self._call("GetPool", pool_service_pb2.GetPoolRequest(name=name), pools_pb2.Pool)

    def get_episode(
        self, pool: PoolName, environment: int, selector: str = "last"
    ) -> episodes_pb2.Episode:
        """Returns an episode of an environment, with everything that a replay needs.

        Args:
            pool: The pool, or its name.
            environment: Index in the pool.
            selector: "last", the last episode that ended, or "current", the running one.

        Returns:
            The message Episode of proto/procgen/v1/episodes.proto, which documents its fields
            (game, options, level_seed, actions, rewards, end) and how to replay it.

        Raises:
            InvalidArgumentError: The environment is out of range, or there is no such `selector`.
            FailedPreconditionError: No episode has ended yet, or the next has not begun.
            UnimplementedError: The server keeps no episodes.
        """
        if selector not in _EPISODE_SELECTORS:
            raise InvalidArgumentError(f'selector is {selector!r}; it is "last" or "current"')
        request = episodes_pb2.GetEpisodeRequest(
            pool=_name_of(pool),
            environment=in_range("environment", environment, -(2**31), 2**31 - 1),
            selector=_EPISODE_SELECTORS[selector],
        )
        return self._call("GetEpisode", request, episodes_pb2.Episode)

    def find_episode(
        self, pool: PoolName, environment: int, fingerprint: int
    ) -> episodes_pb2.Episode:
        """Returns an episode that ended, as :meth:`get_episode`, by its fingerprint.

        Args:
            pool, environment: As get_episode.
            fingerprint: An element of Batch.fingerprints where Batch.ended is true. Not 0.

        Raises:
            InvalidArgumentError: The environment or the fingerprint is out of range.
            NotFoundError: The server has not this episode, or not any more: it has those of a
                pool's last 1,000, or fewer if they are long.
        """
        value = in_range("fingerprint", int(fingerprint), 1, 2**64 - 1)
        request = episodes_pb2.GetEpisodeRequest(
            pool=_name_of(pool),
            environment=in_range("environment", environment, -(2**31), 2**31 - 1),
            fingerprint=value if value < 2**63 else value - 2**64,  # int64 in the message
        )
        return self._call("GetEpisode", request, episodes_pb2.Episode)

    def watch(
        self,
        pool: PoolName,
        environments: Sequence[int] | None = None,
        *,
        size_px: int = 256,
        frames_per_second_max: float = 15.0,
    ) -> Iterator[list[np.ndarray]]:
        """Yields frames of environments while the pool is stepped, without slowing it down.

        The first frames are the current ones, the next follow after changes, at a bounded rate. The
        last state of an episode is shown once, before the start of the next. A slow reader skips
        intermediate frames. The iteration ends with an error or when it is closed; breaking out of
        a loop closes it.

        Args:
            pool: The pool, or its name.
            environments: Indices in the pool, in any order, at most 64. None: the first 16.
            size_px: Side of the square frames in pixels, in [16, 2048]. 64: the agent's
                observation.
            frames_per_second_max: Upper bound of the rate, above 0 and at most 60.

        Yields:
            A frame of each environment, as :meth:`Pool.render` returns them.

        Raises:
            InvalidArgumentError: An environment, the size or the rate is out of range.
            ResourceExhaustedError: The frames take more than 16 MiB, or the caller has too many
                calls (``catalog().limits.owner_call_count_max``).
            AbortedError: The pool has ended.
            UnavailableError: The server drains, or the connection broke.
        """
        if environments is None:
            count = pool.env_count if isinstance(pool, Pool) else self.get_pool(pool).spec.env_count
            environments = range(min(count, 16))
        side = in_range("size_px", size_px, 16, 2048)
        request = render_pb2.WatchPoolRequest(
            pool=_name_of(pool),
            environments=environments,
            size_px=side,
            format=render_pb2.FRAME_FORMAT_RGB,
            frames_per_second_max=frames_per_second_max,
        )
        for moment in self._watch("WatchPool", request, render_pb2.WatchPoolResponse):
            yield [_pixels_of(frame) for frame in moment.frames]

    # The server.

    def catalog(self) -> catalog_pb2.Catalog:
        """Returns the server's catalog: games, modes, options, actions, limits.

        Requested once, on connecting: it does not change while the server runs. The fields are
        documented in proto/procgen/v1/catalog.proto.
        """
        return self._catalog

    def load(self) -> catalog_pb2.Load:
        """Returns the current load of the server."""
        return self._call("GetLoad", catalog_pb2.GetLoadRequest(), catalog_pb2.Load)

    def list_nodes(self) -> cluster_pb2.ListNodesResponse:
        """Returns the servers of the server's cluster; without a cluster the server alone.

        The fields are documented in proto/procgen/v1/cluster.proto.
        """
        return self._call(
            "ListNodes", cluster_pb2.ListNodesRequest(), cluster_pb2.ListNodesResponse
        )

    # Internals.

    def _run(self, call: Any) -> None:  # noqa: ANN401
        """Runs a blocking call of a pool."""
        self._check_open()
        _interruptible.run(call)

    def _call(
        self,
        method: str,
        request: protobuf_message.Message,
        response_type: type[_Message],
    ) -> _Message:
        """Calls a unary method."""
        self._check_open()
        response = self._connection.call(_PATHS[method], request.SerializeToString())
        message: _Message = response_type.FromString(response)
        return message

    def _watch(
        self, method: str, request: protobuf_message.Message, response_type: type[_Message]
    ) -> Iterator[_Message]:
        """Yields the messages of a server stream until it ends or is closed."""
        self._check_open()
        for serialised in self._connection.watch(_PATHS[method], request.SerializeToString()):
            yield response_type.FromString(serialised)

    def _check_open(self) -> None:
        """Raises CancelledError after close, FailedPreconditionError in a forked child."""
        if os.getpid() != self._process_id:
            raise FailedPreconditionError(
                f"the connection to {self.address} belongs to process {self._process_id}, which "
                f"process {os.getpid()} was forked from: start processes that need one with spawn"
            )
        if self._closed:
            raise _connection.closed_error(self.address)


def connect(
    address: str, *, timeout: float | None = None, credentials: Credentials | None = None
) -> Client:
    """Connects to a server; the same as :class:`Client` with these arguments."""
    return Client(address, timeout=timeout, credentials=credentials)


def _name_of(pool: PoolName) -> str:
    return pool.name if isinstance(pool, Pool) else pool


def _pixels_of(frame: render_pb2.Frame) -> np.ndarray:
    return np.frombuffer(frame.image, np.uint8).reshape(frame.size_px, frame.size_px, 3)
