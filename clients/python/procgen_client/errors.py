"""The errors that this package raises.

Every error of a server arrives as a :class:`ProcgenError` with the status code of gRPC and the
server's own message, which says what was given and what is allowed. What the client can tell by
itself (a wrong number of actions, say) is raised as the same classes without asking the server, so
a mistake does not cost the stream.
"""

from __future__ import annotations

import grpc


class ProcgenError(Exception):
    """Something went wrong between this client and a server.

    Attributes:
        code: The status code, a member of :class:`grpc.StatusCode`.
        message: What was given and what is allowed, in words.
    """

    default_code = grpc.StatusCode.UNKNOWN

    def __init__(self, message: str, code: grpc.StatusCode | None = None) -> None:
        """Keeps the message, and the code if it is another than the class's own."""
        super().__init__(message)
        self.message = message
        self.code = self.default_code if code is None else code

    def __str__(self) -> str:
        """Gives e.g. ``NOT_FOUND: no game is called "pong"``."""
        return f"{self.code.name}: {self.message}"

    def __reduce__(self) -> tuple:
        """Lets errors travel between processes."""
        return type(self), (self.message, self.code)


class InvalidArgumentError(ProcgenError, ValueError):
    """A value is out of range, of a wrong length, or asks for what a game lacks: correct it."""

    default_code = grpc.StatusCode.INVALID_ARGUMENT


class UpstreamAssertionError(InvalidArgumentError, AssertionError):
    """An InvalidArgumentError of upstream's interface, where upstream raises AssertionError."""


class NotFoundError(ProcgenError):
    """There is no such game or pool."""

    default_code = grpc.StatusCode.NOT_FOUND


class AlreadyExistsError(ProcgenError):
    """A pool of that name exists: choose another, or none."""

    default_code = grpc.StatusCode.ALREADY_EXISTS


class FailedPreconditionError(ProcgenError):
    """The pool is in the wrong state: another stream is attached, an ended episode is stepped."""

    default_code = grpc.StatusCode.FAILED_PRECONDITION


class AbortedError(ProcgenError):
    """Something else on this pool won: it was deleted, or another stream took over."""

    default_code = grpc.StatusCode.ABORTED


class ResourceExhaustedError(ProcgenError):
    """A limit of the server, which the message names."""

    default_code = grpc.StatusCode.RESOURCE_EXHAUSTED


class UnimplementedError(ProcgenError):
    """In the contract, but not offered by this server: see the catalog's ``features``."""

    default_code = grpc.StatusCode.UNIMPLEMENTED


class UnavailableError(ProcgenError):
    """The server cannot be reached, starts or drains: repeat later, or elsewhere."""

    default_code = grpc.StatusCode.UNAVAILABLE


class DeadlineExceededError(ProcgenError):
    """The server took longer to answer than the client was told to wait."""

    default_code = grpc.StatusCode.DEADLINE_EXCEEDED


class CancelledError(ProcgenError):
    """The call was given up by this client: its channel was closed."""

    default_code = grpc.StatusCode.CANCELLED


class UnauthenticatedError(ProcgenError):
    """The server asks for credentials, and there were none or wrong ones."""

    default_code = grpc.StatusCode.UNAUTHENTICATED


class PermissionDeniedError(ProcgenError):
    """The credentials do not allow this."""

    default_code = grpc.StatusCode.PERMISSION_DENIED


class DataLossError(ProcgenError):
    """A snapshot or an encoded observation is damaged."""

    default_code = grpc.StatusCode.DATA_LOSS


class InternalError(ProcgenError):
    """A bug of the server, or an answer that this client cannot read."""

    default_code = grpc.StatusCode.INTERNAL


_CLASSES = {
    cls.default_code: cls
    for cls in (
        InvalidArgumentError,
        NotFoundError,
        AlreadyExistsError,
        FailedPreconditionError,
        AbortedError,
        ResourceExhaustedError,
        UnimplementedError,
        UnavailableError,
        DeadlineExceededError,
        CancelledError,
        UnauthenticatedError,
        PermissionDeniedError,
        DataLossError,
        InternalError,
    )
}


def from_rpc_error(error: grpc.RpcError) -> ProcgenError:
    """Gives the error of this package for one of gRPC's."""
    code = error.code() if hasattr(error, "code") else grpc.StatusCode.UNKNOWN
    message = (error.details() if hasattr(error, "details") else None) or str(error)
    return _CLASSES.get(code, ProcgenError)(message, code)
