"""A connection to a server."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from google.protobuf import empty_pb2
from google.protobuf import message as protobuf_message

from procgen_client import _fork
from procgen_client import options as _options
from procgen_client._proto import catalog_pb2, cluster_pb2, pools_pb2
from procgen_client._requests import in_range
from procgen_client._transport import open_connection
from procgen_client.credentials import Credentials
from procgen_client.errors import CancelledError, FailedPreconditionError, InternalError
from procgen_client.pool import Pool

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from procgen_client._native import Connection

_Message = TypeVar("_Message", bound=protobuf_message.Message)

# Most slices that a step can be asked to be carried out in (Step.chunk_count).
_CHUNK_COUNT_MAX = 64
# Of clients that were made before this process was forked. Never freed: that would end those of
# the parent.
_abandoned_connections: list[Connection] = []


class Client:
    """A connection to a server, over which pools are made and stepped.

    A context manager: leaving it closes the connection. Pools stay on the server until they are
    deleted, so close them first (each is a context manager, too).

    Threads: any method from any thread; a :class:`Pool` belongs to one thread at a time.

    Processes: it belongs to the one that made it. In a forked child it is closed, which the parent
    does not notice, and what is asked of it and of its pools is FailedPreconditionError.

    Attributes:
        address: What it is connected to.
        reconnect_timeout: How long pools try to go on after a broken connection, in seconds.
    """

    def __init__(
        self,
        address: str,
        *,
        timeout: float = 10.0,
        call_timeout: float = 60.0,
        reconnect_timeout: float = 60.0,
        credentials: Credentials | None = None,
        channel_options: Sequence[tuple[str, Any]] = (),
    ) -> None:
        """Connects.

        Args:
            address: Where the server listens: ``"localhost:50051"``, ``"unix:/run/procgen.sock"``,
                or another target that gRPC knows.
            timeout: How long to wait for the server, in seconds; one that is just starting is
                waited for.
            call_timeout: How long each call besides stepping may take, in seconds.
            reconnect_timeout: How long a pool's stream whose connection broke tries to go on, each
                time, in seconds; the server keeps its answers meanwhile. 0: a broken connection
                ends the stream, and the server keeps nothing.
            credentials: For a server that speaks TLS or asks who calls. None: what the environment
                says (Credentials.from_environment); nothing there: plain text without a token.
            channel_options: More of gRPC's channel arguments.

        Raises:
            UnavailableError: No server answered in time. The message says where and why.
            UnauthenticatedError: The server asks for another token.
            InvalidArgumentError, NotFoundError: As Credentials.arguments.
            UnimplementedError: What answers there is no Procgen Server.
            FailedPreconditionError: The native module is missing, and this process was forked from
                one that has connections.
        """
        self.address = address
        self.reconnect_timeout = reconnect_timeout
        self._closed = False
        self._process_id = os.getpid()
        self._is_abandoned = False  # In a child of that process.
        shown = Credentials.from_environment() if credentials is None else credentials
        self._connection: Connection = open_connection(
            address,
            timeout=timeout,
            call_timeout=call_timeout,
            channel_options=list(channel_options),
            **shown.arguments(address),
        )
        _fork.bind(self)
        try:
            self._catalog = self._first_catalog()
        except BaseException:
            self.close()
            raise

    def __repr__(self) -> str:
        """Gives e.g. ``<Client of localhost:50051>``."""
        return f"<Client of {self.address}{' (closed)' if self._closed else ''}>"

    def __enter__(self) -> Client:
        """Gives the client itself."""
        return self

    def __exit__(self, *exception: object) -> None:
        """Closes the connection."""
        self.close()

    @property
    def closed(self) -> bool:
        """Whether close was called."""
        return self._closed

    def close(self) -> None:
        """Closes the connection. Calls under way end with CancelledError; again: does nothing."""
        if self._is_abandoned:
            return  # Its sockets are shared with the parent.
        self._closed = True
        self._connection.close()

    def abandon(self) -> None:
        """In a forked child: leaves the connection to the parent."""
        self._closed = self._is_abandoned = True
        _abandoned_connections.append(self._connection)

    def check_open(self) -> None:
        """Checks that calls can be made.

        Raises:
            CancelledError: close was called.
            FailedPreconditionError: This is a child of the process that made the connection.
        """
        if self._is_abandoned:
            raise FailedPreconditionError(
                f"the connection to {self.address} belongs to process {self._process_id}, which "
                f"process {os.getpid()} was forked from: make another in here"
            )
        if self._closed:
            raise CancelledError(f"the connection to {self.address} was closed by this client")

    def catalog(self) -> catalog_pb2.Catalog:
        """Returns what the server offers: games, modes, options, actions, limits.

        It does not change while the server runs, so it was asked for once, on connecting. The
        fields are described in proto/procgen/v1/catalog.proto.
        """
        return self._catalog

    def load(self) -> catalog_pb2.Load:
        """Returns the current load of the server."""
        return self._call("GetLoad", catalog_pb2.GetLoadRequest(), catalog_pb2.Load)

    def list_nodes(self) -> cluster_pb2.ListNodesResponse:
        """Returns the servers of the server's cluster; without a cluster the server alone.

        The fields are described in proto/procgen/v1/cluster.proto.
        """
        return self._call(
            "ListNodes", cluster_pb2.ListNodesRequest(), cluster_pb2.ListNodesResponse
        )

    def watch_nodes(self) -> Iterator[cluster_pb2.WatchNodesResponse]:
        """Yields the servers of the cluster: first as they are now, then after each change.

        Ends with an error, or when it is closed; breaking out of a loop over it closes it.

        Raises:
            UnavailableError: The server stops, or the connection broke.
            CancelledError: This client was closed.
        """
        return self._watch(
            "WatchNodes", cluster_pb2.WatchNodesRequest(), cluster_pb2.WatchNodesResponse
        )

    def create_pool(
        self,
        games: str | Sequence[str],
        env_count: int = 64,
        *,
        autoreset_mode: str = "same_step",
        first_env: int = 0,
        total_env_count: int = 0,
        pool_id: str = "",
        requests_in_flight_max: int = 2,
        chunk_count: int | None = None,
        screen_size: int = 64,
        grayscale_obs: bool = False,
        layout: str = "hwc",
        frame_stack: int = 1,
        encoding: str = "raw",
        lease_duration: float | None = None,
        level_sampler: _options.LevelSampler | None = None,
        transport: str = "stream",
        held_batches_max: int = 0,
        **options: Unpack[_options.EnvironmentOptions],
    ) -> Pool:
        """Makes a pool; every environment stands at the first step of its first level.

        Args:
            games, env_count: A game, or several that are dealt in turn to so many environments.
            autoreset_mode: What follows the step that ends an episode. "same_step": the observation
                is the next episode's first. "next_step": it is the last one, and the next step
                begins the next episode. "disabled": it is the last one; a reset must follow.
            first_env, total_env_count: Of a part of a larger pool: where it begins, and
                the whole's number of environments; 0: up to this pool's last.
            pool_id: Last part of the pool's name. Empty: the server chooses.
            requests_in_flight_max: How many requests may be sent ahead of the answers.
            chunk_count: In how many chunks the pool is stepped, 1 to 64. None: as many as pay.
            screen_size, grayscale_obs, layout, frame_stack: See options.observation_format.
            encoding: "raw", or for thin networks "delta_zstd".
            lease_duration: Lease in seconds: time that the pool lives without a stream. None: the
                server's default (10 minutes); 0: no lease.
            level_sampler: Chooses the levels, in place of num_levels and start_level.
            transport: "stream"; or "shared_memory", raw, on the server's machine and as its user.
            held_batches_max: How many shared batches arrays may refer to between steps. 0: 2.
            **options: Those of Procgen 0.10.7, see procgen_client.options.EnvironmentOptions.

        Raises:
            InvalidArgumentError: A value is out of range, or a game does not have that mode.
            NotFoundError, AlreadyExistsError: No such game; `pool_id` is taken.
            ResourceExhaustedError: A limit of the server (``catalog().limits``).
            UnimplementedError: The server or this installation does not support an option.
        """
        spec = _options.pool_spec(
            games,
            env_count,
            options=_options.environment_options(**options),
            autoreset_mode=autoreset_mode,
            first_env=first_env,
            total_env_count=total_env_count,
            observation_format=_options.observation_format(
                screen_size, grayscale_obs, layout, frame_stack
            ),
            encoding=encoding,
            lease_duration=lease_duration,
            level_sampler=level_sampler,
            transport=transport,
        )
        return self.create_pool_from_spec(
            spec,
            pool_id=pool_id,
            requests_in_flight_max=requests_in_flight_max,
            chunk_count=chunk_count,
            held_batches_max=held_batches_max,
        )

    def create_pool_from_spec(
        self,
        spec: pools_pb2.PoolSpec,
        *,
        pool_id: str = "",
        requests_in_flight_max: int = 2,
        chunk_count: int | None = None,
        held_batches_max: int = 0,
    ) -> Pool:
        """Makes a pool from a spec.

        From that of another pool (``Pool.spec``), or one with what create_pool has no name for.

        Errors as :meth:`create_pool`.
        """
        _check_chunk_count(chunk_count)
        request = pools_pb2.CreatePoolRequest(pool_id=pool_id, spec=spec)
        message = self._call("CreatePool", request, pools_pb2.Pool)
        return Pool(
            self,
            message,
            deletes_on_close=True,
            requests_in_flight_max=requests_in_flight_max,
            chunk_count=chunk_count,
            held_batches_max=held_batches_max,
        )

    def get_pool(
        self,
        name: str,
        *,
        requests_in_flight_max: int = 2,
        chunk_count: int | None = None,
        held_batches_max: int = 0,
    ) -> Pool:
        """Gives a pool that is there already; closing it leaves it there.

        Args:
            name: The pool's name.
            requests_in_flight_max, chunk_count: As create_pool takes them.

        Raises:
            InvalidArgumentError: `name` is not of the form ``pools/{pool_id}``, or `chunk_count` is
                out of range.
            NotFoundError: There is no such pool.
        """
        _check_chunk_count(chunk_count)
        message = self._call("GetPool", pools_pb2.GetPoolRequest(name=name), pools_pb2.Pool)
        return Pool(
            self,
            message,
            deletes_on_close=False,
            requests_in_flight_max=requests_in_flight_max,
            chunk_count=chunk_count,
            held_batches_max=held_batches_max,
        )

    def list_pools(self) -> list[pools_pb2.Pool]:
        """Returns the pools, oldest first, as messages (proto/procgen/v1/pools.proto)."""
        request = pools_pb2.ListPoolsRequest()
        return list(self._call("ListPools", request, pools_pb2.ListPoolsResponse).pools)

    def delete_pool(self, name: str) -> None:
        """Ends a pool and frees its environments.

        A stream that is attached to it ends with AbortedError.

        Raises:
            InvalidArgumentError: `name` is not of the form ``pools/{pool_id}``.
            NotFoundError: There is no such pool.
        """
        self._call("DeletePool", pools_pb2.DeletePoolRequest(name=name), empty_pb2.Empty)

    def _call(
        self,
        method: str,
        request: protobuf_message.Message,
        response_type: type[_Message],
    ) -> _Message:
        """Calls a unary method."""
        self.check_open()
        return _parsed(response_type, self._connection.call(method, request.SerializeToString()))

    def _watch(
        self, method: str, request: protobuf_message.Message, response_type: type[_Message]
    ) -> Iterator[_Message]:
        """Gives what a server reports from time to time, until it ends or is closed."""
        self.check_open()
        watch = self._connection.watch(method, request.SerializeToString())
        try:
            for serialised in watch:
                yield _parsed(response_type, serialised)
        finally:
            watch.close()

    def _first_catalog(self) -> catalog_pb2.Catalog:
        catalog = self._call("GetCatalog", catalog_pb2.GetCatalogRequest(), catalog_pb2.Catalog)
        if not catalog.games:
            raise InternalError(f"the server at {self.address} tells of no games")
        return catalog


def _parsed(message_type: type[_Message], serialised: bytes) -> _Message:
    try:
        message: _Message = message_type.FromString(serialised)
        return message
    except protobuf_message.DecodeError as error:
        raise InternalError(f"the server answers no message: {error}") from None


def _check_chunk_count(chunk_count: int | None) -> None:
    if chunk_count is not None:
        in_range("chunk_count", chunk_count, 1, _CHUNK_COUNT_MAX)


def connect(
    address: str, *, timeout: float = 10.0, credentials: Credentials | None = None
) -> Client:
    """Connects to a server; the same as :class:`Client` with these arguments."""
    return Client(address, timeout=timeout, credentials=credentials)
