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
from procgen_client._transport.address import check_address
from procgen_client._transport.selection import why_not_mapped, why_streamed
from procgen_client.credentials import Credentials
from procgen_client.errors import (
    CancelledError,
    FailedPreconditionError,
    InternalError,
    UnauthenticatedError,
)
from procgen_client.pool import Pool

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from procgen_client._native import Connection

_Message = TypeVar("_Message", bound=protobuf_message.Message)

# Upper bound of Step.chunk_count.
_CHUNK_COUNT_MAX = 64
# Connections of clients that were made before this process was forked. Never destroyed, because
# their sockets are shared with the parent.
_abandoned_connections: list[Connection] = []


class Client:
    """A connection to a server, which creates and steps pools.

    A context manager: leaving it closes the connection. Pools stay on the server until they are
    deleted, so close them first (they are context managers, too).

    Threads: any method from any thread; a :class:`Pool` belongs to one thread at a time.

    Processes: it belongs to the process that made it. In a forked child its calls and those of its
    pools raise FailedPreconditionError, and closing it has no effect.

    Attributes:
        address: Address of the server.
        reconnect_timeout: Time for which pools try to resume a broken connection, in seconds.
    """

    def __init__(
        self,
        address: str,
        *,
        timeout: float | None = None,
        call_timeout: float = 60.0,
        reconnect_timeout: float = 60.0,
        credentials: Credentials | None = None,
        channel_options: Sequence[tuple[str, Any]] = (),
    ) -> None:
        """Connects.

        Args:
            address: ``"localhost:50051"``, ``"unix:/run/procgen.sock"`` or another gRPC target.
            timeout: Time to wait for the server, in seconds; it may still be starting. None: 10, or
                1.5 if nothing listens at the address.
            call_timeout: Time limit of each call other than steps, in seconds.
            reconnect_timeout: Time for which a pool tries to resume a broken stream, in seconds;
                the server keeps its unacknowledged answers. 0: a broken connection ends the stream,
                and the server keeps none.
            credentials: TLS certificates and token. None: those of the environment variables
                (Credentials.from_environment).
            channel_options: Additional gRPC channel arguments.

        Raises:
            UnavailableError: No server listens or answers in time; or, at once, it requires TLS,
                has none, or its certificate is not valid for `credentials`. The message has the
                reason.
            UnauthenticatedError: The server requires a token, or another one.
            InvalidArgumentError, NotFoundError: `address` has no port; as Credentials.arguments.
            UnimplementedError: The address belongs to another kind of server.
            FailedPreconditionError: The native module is missing, and this process was forked from
                one that has connections.
        """
        check_address(address)
        self.address = address
        self.reconnect_timeout = reconnect_timeout
        self._closed = False
        self._process_id = os.getpid()
        self._is_abandoned = False  # True in a forked child of that process.
        shown = Credentials.from_environment() if credentials is None else credentials
        try:
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
        if self._is_abandoned:
            return  # The parent uses the sockets.
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

    def watch_nodes(self) -> Iterator[cluster_pb2.WatchNodesResponse]:
        """Yields the servers of the cluster: first the current ones, then after each change.

        The iteration ends with an error or when it is closed; breaking out of a loop closes it.

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
        transport: str = "auto",
        held_batches_max: int = 0,
        copy: bool = True,
        **options: Unpack[_options.EnvironmentOptions],
    ) -> Pool:
        """Creates a pool; each environment is at the first step of its first level.

        Args:
            games, env_count: A game, or several, which alternate; number of environments.
            autoreset_mode: After the step that ends an episode: "same_step" observes the next
                episode, "next_step" starts it with the next step, "disabled" needs a reset.
            first_env, total_env_count: For a part of a larger pool: its first environment in the
                whole and the whole's number of environments (0: up to this pool's last).
            pool_id, requests_in_flight_max: Last part of its name; requests that may be unanswered.
            chunk_count: Chunks of a whole-pool step, 1 to 64. None: one for each 2 MiB, up to 4.
            screen_size, grayscale_obs, layout, frame_stack: See options.observation_format.
            encoding: "raw", or "delta_zstd" for slow networks.
            lease_duration: Lifetime without a stream, in seconds. 0: unlimited. None: 10 minutes.
            level_sampler: Chooses the levels, in place of num_levels and start_level.
            transport: "shared_memory" (raw, on the server's machine, as its user), "stream", or
                "auto", which chooses: see Pool.transport and Pool.transport_reason.
            copy, held_batches_max: False: with shared memory observations are read-only views, and
                arrays may refer to so many batches between steps (0: 2).
            **options: Those of Procgen 0.10.7, see procgen_client.options.EnvironmentOptions.

        Raises:
            InvalidArgumentError, NotFoundError: A value out of range or not of the game; no game.
            AlreadyExistsError, ResourceExhaustedError: `pool_id` is taken; ``catalog().limits``.
            UnimplementedError: The server or this installation does not support an option.
        """
        _options.check_names("Client.create_pool", options, pool_option_names())
        shape = _options.observation_format(screen_size, grayscale_obs, layout, frame_stack)
        spec = _options.pool_spec(
            *(games, env_count),
            options=_options.environment_options(options),
            autoreset_mode=autoreset_mode,
            first_env=first_env,
            total_env_count=total_env_count,
            observation_format=shape,
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
            copy=copy,
        )

    def create_pool_from_spec(
        self,
        spec: pools_pb2.PoolSpec,
        *,
        pool_id: str = "",
        requests_in_flight_max: int = 2,
        chunk_count: int | None = None,
        held_batches_max: int = 0,
        copy: bool = True,
    ) -> Pool:
        """Creates a pool from a spec: another pool's (``Pool.spec``), or one with other fields.

        A spec without a transport is "auto". Arguments and errors as :meth:`create_pool`.
        """
        _check_chunk_count(chunk_count)
        request = pools_pb2.CreatePoolRequest(pool_id=pool_id, spec=spec)

        def create(transport: pools_pb2.Transport, reason: str) -> Pool:
            request.spec.transport = transport
            pool = Pool(
                self,
                self._call("CreatePool", request, pools_pb2.Pool),
                deletes_on_close=True,
                requests_in_flight_max=requests_in_flight_max,
                chunk_count=chunk_count,
                held_batches_max=held_batches_max,
                copy=copy,
            )
            pool.transport_reason = reason
            return pool

        if spec.transport != pools_pb2.TRANSPORT_UNSPECIFIED:
            return create(spec.transport, "the caller chose it")
        reason = why_streamed(self.address, spec.encoding, self._catalog)
        if not reason:
            pool = create(
                pools_pb2.TRANSPORT_SHARED_MEMORY, "this process maps the server's memory"
            )
            reason = why_not_mapped(pool)
            if not reason:
                return pool
        return create(pools_pb2.TRANSPORT_STREAM, reason)

    def get_pool(
        self,
        name: str,
        *,
        requests_in_flight_max: int = 2,
        chunk_count: int | None = None,
        held_batches_max: int = 0,
        copy: bool = True,
    ) -> Pool:
        """Returns an existing pool; closing it does not delete it.

        Args:
            name: The pool's name.
            requests_in_flight_max, chunk_count, held_batches_max, copy: As for create_pool.

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
            copy=copy,
        )

    def list_pools(self) -> list[pools_pb2.Pool]:
        """Returns the pools, oldest first, as messages (proto/procgen/v1/pools.proto)."""
        request = pools_pb2.ListPoolsRequest()
        return list(self._call("ListPools", request, pools_pb2.ListPoolsResponse).pools)

    def delete_pool(self, name: str) -> None:
        """Deletes a pool and its environments.

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
        """Yields the messages of a server stream until it ends or is closed."""
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
            raise InternalError(f"the server at {self.address} has a catalog without games")
        return catalog


def pool_option_names() -> set[str]:
    """Returns the names of the arguments of Client.create_pool, with upstream's options."""
    own = _options.keywords_of(Client.create_pool)
    return own | set(_options.EnvironmentOptions.__annotations__)


def _parsed(message_type: type[_Message], serialised: bytes) -> _Message:
    try:
        message: _Message = message_type.FromString(serialised)
        return message
    except protobuf_message.DecodeError as error:
        raise InternalError(f"the server's answer: not a message: {error}") from None


def _check_chunk_count(chunk_count: int | None) -> None:
    if chunk_count is not None:
        in_range("chunk_count", chunk_count, 1, _CHUNK_COUNT_MAX)


def connect(
    address: str, *, timeout: float | None = None, credentials: Credentials | None = None
) -> Client:
    """Connects to a server; the same as :class:`Client` with these arguments."""
    return Client(address, timeout=timeout, credentials=credentials)
