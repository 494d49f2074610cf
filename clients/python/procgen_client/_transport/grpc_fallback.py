"""The classes of `_native.pyi` over grpcio, for installations without the native module.

Raw observations over the gRPC stream only. A broken connection ends the stream. Slower than the
native module.
"""

from __future__ import annotations

import os
import queue
import time
from collections import deque
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, cast

import grpc
import numpy as np
from google.protobuf.descriptor import FieldDescriptor

from procgen_client import errors
from procgen_client._proto import catalog_pb2, cluster_pb2, pools_pb2, render_pb2, states_pb2
from procgen_client._proto import step_pb2
from procgen_client._transport import connect_error, validation
from procgen_client._transport.address import why_refused
from procgen_client._requests import checked_actions, observation
from procgen_client.credentials import is_this_machine

if TYPE_CHECKING:
    from procgen_client import _native

# Path of each method by its name.
_PATHS = {
    method.name: f"/{service.full_name}/{method.name}"
    for module in (catalog_pb2, cluster_pb2, pools_pb2, render_pb2, states_pb2, step_pb2)
    for service in module.DESCRIPTOR.services_by_name.values()
    for method in service.methods
}
# Element types of arrays by the types of their fields.
_TYPES = {FieldDescriptor.CPPTYPE_FLOAT: "f4", FieldDescriptor.CPPTYPE_BOOL: "?"}
_TYPES |= {FieldDescriptor.CPPTYPE_INT32: "i4", FieldDescriptor.CPPTYPE_INT64: "i8"}
_CHANNEL_OPTIONS: list[tuple[str, int]] = [
    ("grpc.max_receive_message_length", 256 * 1024 * 1024),
    ("grpc.max_send_message_length", -1),
    ("grpc.use_local_subchannel_pool", 1),
    ("grpc.keepalive_time_ms", 20000),
    ("grpc.http2.max_pings_without_data", 0),
    ("grpc.initial_reconnect_backoff_ms", 100),
    ("grpc.min_reconnect_backoff_ms", 100),
    ("grpc.max_reconnect_backoff_ms", 1000),
]
# Connecting without a given timeout: time to wait for a server, and while connections are refused.
_TIMEOUT = 10.0  # Seconds.
_REFUSED_TIMEOUT = 1.5
# Connecting: time between two attempts, and the least time of one, in seconds.
_ATTEMPT_INTERVAL = 0.05
_ATTEMPT_TIMEOUT_MIN = 0.05
_STATE_OVERHEAD_BYTES = 8  # Tag and length of a snapshot in a request.
_connected_process = 0  # Id of the process that has connections: this one, or its parent.


def open_connection(address: str, **arguments: Any) -> _native.Connection:  # noqa: ANN401
    """Connects; arguments as `_native.Connection`."""
    return cast("_native.Connection", Connection(address, **arguments))


class Connection:
    """A connection to a server."""

    def __init__(
        self, address: str, *, timeout: float | None, call_timeout: float, token: str, **others: Any
    ) -> None:
        """Connects."""
        global _connected_process
        if _connected_process not in (0, os.getpid()):
            raise errors.FailedPreconditionError(
                f"process {os.getpid()} cannot connect to {address}: it was forked from process "
                f"{_connected_process}, which has grpcio connections. Start processes with "
                'multiprocessing.get_context("spawn"), or connect only after the fork'
            )
        _connected_process = os.getpid()
        self._call_timeout = call_timeout
        self.metadata = (("authorization", f"Bearer {token}"),) if token else ()
        options = [*_CHANNEL_OPTIONS, *others["channel_options"]]
        if is_this_machine(address):
            options.append(("grpc.enable_http_proxy", 0))
        if others["ca"]:
            pems = [others[name] or None for name in ("ca", "key", "certificate")]
            tls = grpc.ssl_channel_credentials(*pems)
            self.channel = grpc.secure_channel(address, tls, options)
        else:
            self.channel = grpc.insecure_channel(address, options)
        try:
            catalog = self._first_answer(address, timeout, uses_tls=bool(others["ca"]))
        except BaseException:
            self.channel.close()
            raise
        self._limits = catalog_pb2.Catalog.FromString(catalog).limits

    def call(self, method: str, request: bytes) -> bytes:
        """Calls a unary method."""
        if method == "CreatePool":
            _require_plain(pools_pb2.CreatePoolRequest.FromString(request).spec)
        if method == "RestoreStates":
            return self._restore(states_pb2.RestoreStatesRequest.FromString(request))
        if method in ("ListPools", "SaveStates"):
            return self._pages(method, request)
        return validation.checked(method, request, self._unary(method, request))

    def watch(self, method: str, request: bytes) -> Iterator[bytes]:
        """Calls "WatchNodes" or "WatchPool" and yields the messages."""
        call = self.channel.unary_stream(_PATHS[method])(request, metadata=self.metadata)
        try:
            yield from call
        except grpc.RpcError as error:
            raise _of_rpc_error(error) from None
        finally:
            call.cancel()

    def attach(self, attach: bytes, reconnect_timeout: float, held_batches: None) -> Stream:
        """Attaches."""
        return Stream(self, step_pb2.Attach.FromString(attach))

    def close(self) -> None:
        """Ends all calls with CancelledError."""
        self.channel.close()

    def _pages(self, method: str, serialised: bytes) -> bytes:
        module: Any = pools_pb2 if method == "ListPools" else states_pb2
        request = getattr(module, f"{method}Request").FromString(serialised)
        whole = getattr(module, f"{method}Response")()
        for _ in range(validation.PAGES_MAX):
            response = self._unary(method, request.SerializeToString())
            page = validation.parse(type(whole), response, method)
            if method == "SaveStates":
                validation.check_states(page, request, len(whole.states))
            whole.MergeFrom(page)
            request.page_token = page.next_page_token
            if not request.page_token:
                return cast(bytes, whole.SerializeToString())
        raise errors.InternalError(f"{method}: more than {validation.PAGES_MAX} pages")

    def _restore(self, request: states_pb2.RestoreStatesRequest) -> bytes:
        part = states_pb2.RestoreStatesRequest(pool=request.pool)
        for state in request.states:
            bytes_after = part.ByteSize() + state.ByteSize() + _STATE_OVERHEAD_BYTES
            if part.states and bytes_after > self._limits.request_bytes_max:
                self._unary("RestoreStates", part.SerializeToString())
                del part.states[:]
            part.states.append(state)
        return self._unary("RestoreStates", part.SerializeToString())

    def _unary(self, method: str, request: bytes, timeout: float | None = None) -> bytes:
        timeout = self._call_timeout if timeout is None else timeout
        call = self.channel.unary_unary(_PATHS[method])
        try:
            return cast(bytes, call(request, timeout=timeout, metadata=self.metadata))
        except grpc.RpcError as error:
            raise _of_rpc_error(error) from None

    def _first_answer(self, address: str, timeout: float | None, *, uses_tls: bool) -> bytes:
        """Returns the catalog; repeats the call while the server may still be starting."""
        begin = time.monotonic()
        deadline = begin + (_TIMEOUT if timeout is None else timeout)
        refused_deadline = begin + _REFUSED_TIMEOUT if timeout is None else deadline
        while True:
            left = deadline - time.monotonic()
            try:
                return self._unary("GetCatalog", b"", max(left, _ATTEMPT_TIMEOUT_MIN))
            except (errors.UnavailableError, errors.DeadlineExceededError) as error:
                reason = error.message
            explanation = connect_error.explain(address, reason, uses_tls=uses_tls)
            if explanation:
                raise errors.UnavailableError(f"cannot connect to {address}: {explanation}")
            refusal = why_refused(address)
            now = time.monotonic() + _ATTEMPT_INTERVAL
            if refusal and now >= refused_deadline:
                raise errors.UnavailableError(f"no server listens at {address}: {refusal}")
            if now >= deadline:
                cause = connect_error.likely_cause(reason, uses_tls=uses_tls)
                raise errors.UnavailableError(
                    f"no server answers at {address} within {deadline - begin:g} s: {reason}{cause}"
                )
            time.sleep(_ATTEMPT_INTERVAL)


class Batch:
    """An answer: the responses of one request."""

    def __init__(self, parts: list[step_pb2.StepPoolResponse], shape: tuple[int, ...]) -> None:
        """Keeps the responses."""
        self.sequence_number = parts[0].sequence_number
        self.first_env = parts[0].batch.first_env
        self._parts = [part.batch for part in parts]
        self._shape = shape

    def array(self, name: str) -> np.ndarray | None:
        """Makes the array of this name."""
        values = [getattr(part, name) for part in self._parts]
        dtype = _TYPES.get(step_pb2.Batch.DESCRIPTOR.fields_by_name[name].cpp_type)
        if dtype is not None:
            numbers: np.ndarray = np.concatenate([np.array(each, dtype) for each in values])
            # Fingerprints are signed in the message, unsigned in the API.
            return np.array(numbers, "u8") if dtype == "i8" else numbers
        joined = np.frombuffer(bytearray().join(values), np.uint8).reshape(-1, *self._shape)
        return joined if len(joined) or name == "final_observations" else None


class Stream:
    """The stream of an attached learner."""

    held_batches = None

    def __init__(self, connection: Connection, attach: step_pb2.Attach) -> None:
        """Attaches."""
        self._pool = attach.pool
        self._unanswered: deque[step_pb2.StepPoolRequest] = deque()  # Oldest first.
        self._requests: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self._requests.put(step_pb2.StepPoolRequest(attach=attach).SerializeToString())
        method = connection.channel.stream_stream(_PATHS["StepPool"])
        self._call = method(iter(self._requests.get, None), metadata=connection.metadata)
        attached = self._read().attached
        validation.check_attached(attached, attach.pool)
        _require_plain(attached.pool.spec)
        self.requests_in_flight_max = attached.requests_in_flight_max
        self._next_number = attached.next_sequence_number
        self._attached_pool = attached.pool

    @property
    def in_flight(self) -> int:
        """Number of requests whose answers were not received."""
        return len(self._unanswered)

    def send(self, request: bytes) -> int:
        """Sends a StepPoolRequest."""
        message = step_pb2.StepPoolRequest.FromString(request)
        message.sequence_number = self._next_number
        self._next_number += 1
        self._unanswered.append(message)
        self._requests.put(message.SerializeToString())
        return message.sequence_number

    def send_step(self, actions: np.ndarray, first: int, *rest: Any) -> int:  # noqa: ANN401
        """Sends a step; arguments as `_native.Stream.send_step`."""
        repeat_count, observe, final_observations, chunk_count, more = rest
        step = step_pb2.Step(
            slice=step_pb2.Slice(first_env=first, env_count=len(actions)),
            actions=checked_actions(actions).tolist(),
            repeat_count=repeat_count,
            observation=observation(observe),
            with_final_observations=final_observations,
            chunk_count=chunk_count,
        )
        step.MergeFromString(more)
        return self.send(step_pb2.StepPoolRequest(step=step).SerializeToString())

    def receive(self) -> Batch:
        """Waits for the answer to the oldest unanswered request."""
        request = self._unanswered[0]
        parts: list[step_pb2.StepPoolResponse] = []
        notices = env_count = 0
        while notices <= validation.NOTICES_MAX:
            part = self._read()
            if part.WhichOneof("response") is None and not part.sequence_number:
                notices += 1  # A message of a later version; it is not an answer.
                continue
            validation.check_part(part, request, env_count, self._attached_pool)
            parts.append(part)
            env_count += part.batch.env_count
            if part.batch.last or part.HasField("ack"):
                self._unanswered.popleft()
                return Batch(parts, tuple(self._attached_pool.observation_shape))
        raise errors.InternalError(f"{self._pool} sends more than {notices - 1} unknown responses")

    def close(self) -> None:
        """Ends the stream and waits for the server to end it."""
        self._requests.put(None)
        try:
            deque(self._call, maxlen=0)
        except grpc.RpcError:
            pass

    def cancel(self) -> None:
        """Ends the stream at once; in a forked child does nothing."""
        if os.getpid() == _connected_process:
            self._requests.put(None)
            self._call.cancel()

    __del__ = cancel

    def _read(self) -> step_pb2.StepPoolResponse:
        try:
            message = next(self._call, None)
        except grpc.RpcError as error:
            raise _of_rpc_error(error) from None
        if message is None:
            raise errors.UnavailableError(f"the server ended the stream of {self._pool}")
        return validation.parse(step_pb2.StepPoolResponse, message, self._pool)


def _require_plain(spec: pools_pb2.PoolSpec) -> None:
    if spec.encoding > pools_pb2.ENCODING_RAW or spec.transport > pools_pb2.TRANSPORT_STREAM:
        raise errors.UnimplementedError(
            "compressed observations and shared memory need the module procgen_client._native, "
            "which is not installed; without it pools are raw and streamed"
        )


def _of_rpc_error(error: grpc.RpcError) -> errors.ProcgenError:
    return errors.of_code(error.code().value[0], error.details() or str(error))
