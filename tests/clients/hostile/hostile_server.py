"""A proxy between learners and a real server that changes responses.

It forwards gRPC messages as bytes and parses only those that its mode changes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent import futures

import grpc
import hostile_answers
import mutated_answers

_UNLIMITED = [("grpc.max_receive_message_length", -1), ("grpc.max_send_message_length", -1)]
_WATCHES = ("WatchNodes", "WatchPool")


class HostileServer(grpc.GenericRpcHandler):
    """A server that listens at `address`."""

    def __init__(self, mode: str, target: str) -> None:
        """Starts listening."""
        self._mode = mode
        self._channel = grpc.insecure_channel(
            target, [*_UNLIMITED, ("grpc.use_local_subchannel_pool", 1)]
        )
        self._server = grpc.server(futures.ThreadPoolExecutor(8), options=_UNLIMITED)
        self._server.add_generic_rpc_handlers((self,))
        self.address = f"127.0.0.1:{self._server.add_insecure_port('127.0.0.1:0')}"
        self._server.start()

    def stop(self) -> None:
        """Ends all calls."""
        self._server.stop(0)
        self._channel.close()

    def service(self, handler_call_details: grpc.HandlerCallDetails) -> grpc.RpcMethodHandler:
        """Returns the handler of a call."""
        method = handler_call_details.method
        name = method.rsplit("/", 1)[-1]
        if name == "StepPool":
            return grpc.stream_stream_rpc_method_handler(_with_status(self._step_pool(method)))
        if name in _WATCHES:
            return grpc.unary_stream_rpc_method_handler(
                _with_status(lambda request, _: self._channel.unary_stream(method)(request))
            )
        return grpc.unary_unary_rpc_method_handler(self._unary(method, name))

    def _step_pool(self, method: str) -> Callable[..., Iterator[bytes]]:
        def answer(requests: Iterator[bytes], context: grpc.ServicerContext) -> Iterator[bytes]:
            call = self._channel.stream_stream(method)(requests)
            context.add_callback(call.cancel)
            for received in call:
                message = mutated_answers.stream_answer(self._mode, received)
                for changed in hostile_answers.stream_answers(self._mode, message):
                    if not context.is_active():
                        return
                    yield changed

        return answer

    def _unary(self, method: str, name: str) -> Callable[..., bytes]:
        def answer(request: bytes, context: grpc.ServicerContext) -> bytes:
            try:
                message = self._channel.unary_unary(method)(request, timeout=20)
            except grpc.RpcError as error:
                context.abort(error.code(), error.details())
            if self._mode == "compressed":
                context.set_compression(grpc.Compression.Gzip)
            message = mutated_answers.unary_answer(self._mode, name, message)
            return hostile_answers.unary_answer(self._mode, name, message)

        return answer


def _with_status(answer: Callable[..., Iterator[bytes]]) -> Callable[..., Iterator[bytes]]:
    """Ends a call with the status of the real server."""

    def ended(request: object, context: grpc.ServicerContext) -> Iterator[bytes]:
        try:
            yield from answer(request, context)
        except grpc.RpcError as error:
            context.abort(error.code(), error.details())

    return ended
