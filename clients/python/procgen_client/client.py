"""A connection to a server."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import grpc
from google.protobuf import message as protobuf_message

from procgen_client import _fork
from procgen_client import options as _options
from procgen_client._proto import (
    catalog_pb2,
    catalog_pb2_grpc,
    cluster_pb2,
    cluster_pb2_grpc,
    pools_pb2,
    pools_pb2_grpc,
    render_pb2,
    render_pb2_grpc,
    states_pb2,
    states_pb2_grpc,
)
from procgen_client._requests import in_range
from procgen_client._transport.channel_call import ChannelCall
from procgen_client._transport.encoding import check_decodable
from procgen_client._transport.http2 import MESSAGE_BYTES_MAX, Http2Call
from procgen_client._transport.http2_channel import Http2Channel
from procgen_client._transport.latest import latest_of
from procgen_client._transport.target import Target
from procgen_client._validation import POOL_PAGES_MAX, check_pool
from procgen_client.credentials import Credentials, is_this_machine
from procgen_client.errors import (
    CancelledError,
    DeadlineExceededError,
    FailedPreconditionError,
    InternalError,
    UnavailableError,
    from_rpc_error,
)
from procgen_client.pool import Pool

if TYPE_CHECKING:
    from typing_extensions import Unpack

STEP_POOL_METHOD = "/procgen.v1.StepService/StepPool"
# Most chunks that a step can be asked to be carried out in (Step.chunk_count).
_CHUNK_COUNT_MAX = 64
# Of clients that were made before this process was forked. Never freed: that would end those of
# the parent.
_abandoned_channels: list[Http2Channel | grpc.Channel] = []


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
            channel_options: More of gRPC's channel arguments; connections are grpcio's then.

        Raises:
            UnavailableError: No server answered in time. The message says where and why.
            UnauthenticatedError: The server asks for another token.
            InvalidArgumentError, NotFoundError: As Credentials.channel.
            UnimplementedError: What answers there is no Procgen Server.
            FailedPreconditionError: It takes grpcio (TLS, a proxy, `channel_options`), and this
                process was forked from one that has such connections.
        """
        self.address = address
        self.reconnect_timeout = reconnect_timeout
        self._call_timeout = call_timeout
        self._closed = False
        self._process_id = os.getpid()
        self._is_abandoned = False  # In a child of that process.
        shown = Credentials.from_environment() if credentials is None else credentials
        is_plain = shown.ca is None and not channel_options
        target = Target.of(address) if is_plain else None
        if target is None:
            _fork.use_grpc(address)
            arguments = [*channel_arguments(address), *channel_options]
            self._channel = shown.channel(address, arguments)
        else:
            shown.check(address)
            self._channel = Http2Channel(target)
        self._metadata = shown.metadata()
        self._catalog_stub = catalog_pb2_grpc.CatalogServiceStub(self._channel)
        self._cluster_stub = cluster_pb2_grpc.ClusterServiceStub(self._channel)
        self._pool_stub = pools_pb2_grpc.PoolServiceStub(self._channel)
        self._state_stub = states_pb2_grpc.StateServiceStub(self._channel)
        self._render_stub = render_pb2_grpc.RenderServiceStub(self._channel)
        _fork.bind(self)
        try:
            self._catalog = self._first_catalog(timeout)
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
        self._channel.close()

    def abandon(self) -> None:
        """In a forked child: leaves the connection to the parent."""
        self._closed = self._is_abandoned = True
        _abandoned_channels.append(self._channel)

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
        """Tells what the server offers: games, modes, options, actions, limits.

        It does not change while the server runs, so it was asked for once, on connecting. The
        fields are described in proto/procgen/v1/catalog.proto.
        """
        return self._catalog

    def load(self) -> catalog_pb2.Load:
        """Tells how busy the server is at this moment."""
        return self._unary(self._catalog_stub.GetLoad, catalog_pb2.GetLoadRequest())

    def list_nodes(self) -> cluster_pb2.ListNodesResponse:
        """Tells which servers there are in the server's cluster; it alone where it has none.

        The fields are described in proto/procgen/v1/cluster.proto.
        """
        return self._unary(self._cluster_stub.ListNodes, cluster_pb2.ListNodesRequest())

    def watch_nodes(self) -> Iterator[cluster_pb2.WatchNodesResponse]:
        """Tells which servers there are: at first as they are now, then after each change.

        Ends with an error, or when it is closed; breaking out of a loop over it closes it.

        Raises:
            UnavailableError: The server stops, or the connection broke.
            CancelledError: This client was closed.
        """
        return self._watch(self._cluster_stub.WatchNodes, cluster_pb2.WatchNodesRequest())

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
            screen_size, grayscale_obs, layout, frame_stack: As options.observation_format tells.
            encoding: "raw", or for thin networks "delta_zstd".
            lease_duration: How long it lives while nobody steps it, in seconds. None: for good.
            level_sampler: Chooses the levels, in place of num_levels and start_level.
            transport: "stream"; or "shared_memory", raw, on the server's machine and as its user.
            held_batches_max: How many shared batches arrays may refer to between steps. 0: 2.
            **options: Those of Procgen 0.10.7, as procgen_client.options.EnvironmentOptions tells.

        Raises:
            InvalidArgumentError: A value is out of range, or a game lacks that mode.
            NotFoundError, AlreadyExistsError: No such game; `pool_id` is taken.
            ResourceExhaustedError: A limit of the server (``catalog().limits``).
            UnimplementedError: The server lacks this option, or this machine the package for it.
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
        check_decodable(spec.encoding)
        _check_chunk_count(chunk_count)
        request = pools_pb2.CreatePoolRequest(pool_id=pool_id, spec=spec)
        message = self._unary(self._pool_stub.CreatePool, request)
        check_pool(message, f"pools/{pool_id}" if pool_id else None, spec.env_count)
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
        message = self._unary(self._pool_stub.GetPool, pools_pb2.GetPoolRequest(name=name))
        check_pool(message, name)
        return Pool(
            self,
            message,
            deletes_on_close=False,
            requests_in_flight_max=requests_in_flight_max,
            chunk_count=chunk_count,
            held_batches_max=held_batches_max,
        )

    def list_pools(self) -> list[pools_pb2.Pool]:
        """Tells what pools there are, oldest first, as messages (proto/procgen/v1/pools.proto)."""
        pools: list[pools_pb2.Pool] = []
        request = pools_pb2.ListPoolsRequest()
        for _ in range(POOL_PAGES_MAX):
            response = self._unary(self._pool_stub.ListPools, request)
            pools += response.pools
            request.page_token = response.next_page_token
            if not request.page_token:
                return pools
        raise InternalError(f"a list of pools has more than {POOL_PAGES_MAX} pages")

    def delete_pool(self, name: str) -> None:
        """Ends a pool and frees its environments.

        A stream that is attached to it ends with AbortedError.

        Raises:
            InvalidArgumentError: `name` is not of the form ``pools/{pool_id}``.
            NotFoundError: There is no such pool.
        """
        self._unary(self._pool_stub.DeletePool, pools_pb2.DeletePoolRequest(name=name))

    def _step_pool(self, timeout: float | None) -> ChannelCall | Http2Call:
        """Begins a call of StepPool, for which the server is waited for so long, if it has to be.

        In place of the generated stub: requests and responses are bytes.
        """
        self.check_open()
        if isinstance(self._channel, Http2Channel):
            return self._channel.stream_stream(STEP_POOL_METHOD, self._metadata, timeout)
        return ChannelCall(
            self._channel.stream_stream(STEP_POOL_METHOD),
            self._metadata,
            waits_for_server=timeout is not None,
        )

    def _renew_pool(self, request: pools_pb2.RenewPoolRequest) -> pools_pb2.Pool:
        return self._unary(self._pool_stub.RenewPool, request)

    def _save_states(self, request: states_pb2.SaveStatesRequest) -> states_pb2.SaveStatesResponse:
        return self._unary(self._state_stub.SaveStates, request)

    def _restore_states(self, request: states_pb2.RestoreStatesRequest) -> None:
        self._unary(self._state_stub.RestoreStates, request)

    def _clone_states(self, request: states_pb2.CloneStatesRequest) -> None:
        self._unary(self._state_stub.CloneStates, request)

    def _get_episode(self, request: states_pb2.GetEpisodeRequest) -> states_pb2.Episode:
        return self._unary(self._state_stub.GetEpisode, request)

    def _render_environments(
        self, request: render_pb2.RenderEnvironmentsRequest
    ) -> render_pb2.RenderEnvironmentsResponse:
        return self._unary(self._render_stub.RenderEnvironments, request)

    def _watch_pool(
        self, request: render_pb2.WatchPoolRequest
    ) -> Iterator[render_pb2.WatchPoolResponse]:
        return self._watch(self._render_stub.WatchPool, request)

    def _watch(
        self, method: Callable[..., Any], request: protobuf_message.Message
    ) -> Iterator[Any]:
        """Gives what a server tells from time to time, until it ends or is closed."""
        call = self._unary(method, request, timeout=None)
        try:
            yield from latest_of(call)
        except grpc.RpcError as error:
            raise from_rpc_error(error) from None
        finally:
            call.cancel()

    def _unary(
        self, method: Callable[..., Any], request: protobuf_message.Message, **arguments: Any
    ) -> Any:  # noqa: ANN401
        self.check_open()
        try:
            return method(
                request,
                **({"timeout": self._call_timeout, "metadata": self._metadata} | arguments),
            )
        except grpc.RpcError as error:
            raise from_rpc_error(error) from None

    def _first_catalog(self, timeout: float) -> catalog_pb2.Catalog:
        try:
            # Not by channel_ready_future, which takes 0.2 s also where the server is there.
            catalog = self._unary(
                self._catalog_stub.GetCatalog,
                catalog_pb2.GetCatalogRequest(),
                timeout=timeout,
                wait_for_ready=True,
            )
        except DeadlineExceededError:
            raise UnavailableError(
                f"no server answers at {self.address} ({self._reason()}); waited {timeout:g} s"
            ) from None
        if not catalog.games:
            raise InternalError(f"the server at {self.address} tells of no games")
        return catalog

    def _reason(self) -> str:
        """Tells why the connection fails, in gRPC's words."""
        try:
            self._catalog_stub.GetCatalog(
                catalog_pb2.GetCatalogRequest(), timeout=1, metadata=self._metadata
            )
        except grpc.RpcError as error:
            return error.details() or error.code().name
        return "it has just begun to"


def _check_chunk_count(chunk_count: int | None) -> None:
    if chunk_count is not None:
        in_range("chunk_count", chunk_count, 1, _CHUNK_COUNT_MAX)


def connect(
    address: str, *, timeout: float = 10.0, credentials: Credentials | None = None
) -> Client:
    """Connects to a server; the same as :class:`Client` with these arguments."""
    return Client(address, timeout=timeout, credentials=credentials)


def channel_arguments(address: str) -> list[tuple[str, Any]]:
    """Gives the arguments of a channel to a server."""
    arguments: list[tuple[str, Any]] = [
        # Attach says how large responses may be, and far less is usual. This bounds what a faulty
        # server can make this process take.
        ("grpc.max_receive_message_length", MESSAGE_BYTES_MAX),
        # Servers compress nothing, and some kilobytes could become gigabytes.
        ("grpc.compression_enabled_algorithms_bitset", 1),
        ("grpc.per_message_decompression", 0),
        ("grpc.max_send_message_length", -1),
        # A connection of its own for each client, so that several in one process do not share one.
        ("grpc.use_local_subchannel_pool", 1),
        # A connection that is silent is asked for a sign of life, so that a dead one is found.
        ("grpc.keepalive_time_ms", 20000),
        ("grpc.keepalive_timeout_ms", 10000),
        ("grpc.http2.max_pings_without_data", 0),
        # A server that is just starting is found soon.
        ("grpc.initial_reconnect_backoff_ms", 100),
        ("grpc.min_reconnect_backoff_ms", 100),
        ("grpc.max_reconnect_backoff_ms", 1000),
    ]
    if is_this_machine(address):
        # This very machine is never behind a proxy, whatever http_proxy says.
        arguments.append(("grpc.enable_http_proxy", 0))
    return arguments
