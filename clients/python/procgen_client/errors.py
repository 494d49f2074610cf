"""The errors that this package raises.

Every error of a server arrives as a :class:`ProcgenError` with the status code of gRPC and the
server's own message, which says what was given and what is allowed. What the client can tell by
itself (a wrong number of actions, say) is raised as the same classes without asking the server, so
a mistake does not cost the stream.
"""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from grpc import StatusCode
else:
    try:
        from grpc import StatusCode
    except ImportError:  # The native module needs no grpcio.

        class StatusCode(enum.Enum):
            """The status codes, as those of grpcio, which is not installed."""

            OK = (0, "ok")
            CANCELLED = (1, "cancelled")
            UNKNOWN = (2, "unknown")
            INVALID_ARGUMENT = (3, "invalid argument")
            DEADLINE_EXCEEDED = (4, "deadline exceeded")
            NOT_FOUND = (5, "not found")
            ALREADY_EXISTS = (6, "already exists")
            PERMISSION_DENIED = (7, "permission denied")
            RESOURCE_EXHAUSTED = (8, "resource exhausted")
            FAILED_PRECONDITION = (9, "failed precondition")
            ABORTED = (10, "aborted")
            OUT_OF_RANGE = (11, "out of range")
            UNIMPLEMENTED = (12, "unimplemented")
            INTERNAL = (13, "internal")
            UNAVAILABLE = (14, "unavailable")
            DATA_LOSS = (15, "data loss")
            UNAUTHENTICATED = (16, "unauthenticated")


class ProcgenError(Exception):
    """Something went wrong between this client and a server.

    Attributes:
        code: The status code, a member of :class:`grpc.StatusCode`.
        message: What was given and what is allowed, in words.
    """

    default_code = StatusCode.UNKNOWN

    def __init__(self, message: str, code: StatusCode | None = None) -> None:
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


class ServerNotFoundError(ProcgenError, FileNotFoundError):
    """There is no server program to start; the message lists the places that were tried."""

    default_code = StatusCode.NOT_FOUND


class InvalidArgumentError(ProcgenError, ValueError):
    """A value is out of range, of a wrong length, or not available in a game: correct it."""

    default_code = StatusCode.INVALID_ARGUMENT


class UpstreamAssertionError(InvalidArgumentError, AssertionError):
    """An InvalidArgumentError of upstream's interface, where upstream raises AssertionError."""


class NotFoundError(ProcgenError):
    """There is no such game or pool."""

    default_code = StatusCode.NOT_FOUND


class AlreadyExistsError(ProcgenError):
    """A pool of that name exists: choose another, or none."""

    default_code = StatusCode.ALREADY_EXISTS


class FailedPreconditionError(ProcgenError):
    """The pool is in the wrong state: another stream is attached, an ended episode is stepped."""

    default_code = StatusCode.FAILED_PRECONDITION


class AbortedError(ProcgenError):
    """Something else on this pool won: it was deleted, or another stream took over."""

    default_code = StatusCode.ABORTED


class ResourceExhaustedError(ProcgenError):
    """A limit of the server, which the message names."""

    default_code = StatusCode.RESOURCE_EXHAUSTED


class UnimplementedError(ProcgenError):
    """In the contract, but not offered by this server: see the catalog's ``features``."""

    default_code = StatusCode.UNIMPLEMENTED


class UnavailableError(ProcgenError):
    """The server cannot be reached, starts or drains: repeat later, or elsewhere."""

    default_code = StatusCode.UNAVAILABLE


class DeadlineExceededError(ProcgenError):
    """The server took longer to answer than the client was told to wait."""

    default_code = StatusCode.DEADLINE_EXCEEDED


class CancelledError(ProcgenError):
    """The call was given up by this client: its channel was closed."""

    default_code = StatusCode.CANCELLED


class UnauthenticatedError(ProcgenError):
    """The server asks for credentials, and there were none or wrong ones."""

    default_code = StatusCode.UNAUTHENTICATED


class PermissionDeniedError(ProcgenError):
    """The credentials do not allow this."""

    default_code = StatusCode.PERMISSION_DENIED


class DataLossError(ProcgenError):
    """A snapshot is damaged, or an answer of a stream does not fit its request."""

    default_code = StatusCode.DATA_LOSS


class InternalError(ProcgenError):
    """A bug of the server, or an answer that this client cannot read."""

    default_code = StatusCode.INTERNAL


_CODES: dict[int, StatusCode] = {code.value[0]: code for code in StatusCode}
_CLASSES: dict[StatusCode, type[ProcgenError]] = {
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


def of_code(number: int, message: str) -> ProcgenError:
    """Gives the error of this package for a status code of gRPC, by its number."""
    code = _CODES.get(number, StatusCode.UNKNOWN)
    return _CLASSES.get(code, ProcgenError)(message, code)
