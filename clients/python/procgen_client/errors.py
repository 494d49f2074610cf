"""The exceptions of this package.

Each is a :class:`ProcgenError` with a status code and a message, which has the value given and the
values allowed. Pools in this process and on servers raise the same classes.
"""

from __future__ import annotations

import enum


class StatusCode(enum.IntEnum):
    """gRPC's status codes, by their numbers."""

    OK = 0
    CANCELLED = 1
    UNKNOWN = 2
    INVALID_ARGUMENT = 3
    DEADLINE_EXCEEDED = 4
    NOT_FOUND = 5
    ALREADY_EXISTS = 6
    PERMISSION_DENIED = 7
    RESOURCE_EXHAUSTED = 8
    FAILED_PRECONDITION = 9
    ABORTED = 10
    OUT_OF_RANGE = 11
    UNIMPLEMENTED = 12
    INTERNAL = 13
    UNAVAILABLE = 14
    DATA_LOSS = 15
    UNAUTHENTICATED = 16


class ProcgenError(Exception):
    """Base class of all errors of this package.

    Attributes:
        code: The status code.
        message: The text: the value given and the values allowed.
    """

    default_code = StatusCode.UNKNOWN

    def __init__(self, message: str, code: StatusCode | None = None) -> None:
        """Takes the message, and the code. None: the class's default_code."""
        super().__init__(message)
        self.message = message
        self.code = self.default_code if code is None else code

    def __str__(self) -> str:
        """Returns e.g. ``NOT_FOUND: no game is called "pong"``."""
        return f"{self.code.name}: {self.message}"

    def __reduce__(self) -> tuple:
        """Supports pickle, for errors that are sent between processes."""
        return type(self), (self.message, self.code)


class InvalidArgumentError(ProcgenError, ValueError):
    """A value is out of range, of a wrong length, or not available in a game."""

    default_code = StatusCode.INVALID_ARGUMENT


class UpstreamAssertionError(InvalidArgumentError, AssertionError):
    """An InvalidArgumentError of upstream's API, where upstream raises AssertionError."""


class UnknownOptionError(InvalidArgumentError, TypeError):
    """There is no such option; the message has the nearest name and all names.

    A TypeError as well, as for any unknown keyword argument in Python.
    """


class NotFoundError(ProcgenError):
    """There is no such game or pool."""

    default_code = StatusCode.NOT_FOUND


class ServerNotFoundError(NotFoundError, FileNotFoundError):
    """There is no server program to start; the message lists the places that were tried."""


class AlreadyExistsError(ProcgenError):
    """A pool of that name exists. An empty `pool_id` lets the server choose."""

    default_code = StatusCode.ALREADY_EXISTS


class FailedPreconditionError(ProcgenError):
    """The pool is in the wrong state: requests are unanswered, an ended episode is stepped."""

    default_code = StatusCode.FAILED_PRECONDITION


class AbortedError(ProcgenError):
    """The pool was closed, or another thread uses it."""

    default_code = StatusCode.ABORTED


class ResourceExhaustedError(ProcgenError):
    """A limit of the server is reached; the message names it."""

    default_code = StatusCode.RESOURCE_EXHAUSTED


class UnimplementedError(ProcgenError):
    """The server does not offer this part of the API."""

    default_code = StatusCode.UNIMPLEMENTED


class UnavailableError(ProcgenError):
    """The server is unreachable, starting or draining: retry later, or use another server."""

    default_code = StatusCode.UNAVAILABLE


class DeadlineExceededError(ProcgenError):
    """The server did not answer within the time limit of the call."""

    default_code = StatusCode.DEADLINE_EXCEEDED


class CancelledError(ProcgenError):
    """This client closed its connection during the call."""

    default_code = StatusCode.CANCELLED


class UnauthenticatedError(ProcgenError):
    """The server requires credentials, and they are missing or wrong."""

    default_code = StatusCode.UNAUTHENTICATED


class PermissionDeniedError(ProcgenError):
    """The credentials do not allow this."""

    default_code = StatusCode.PERMISSION_DENIED


class DataLossError(ProcgenError):
    """A snapshot is damaged, or an answer does not match its request."""

    default_code = StatusCode.DATA_LOSS


class InternalError(ProcgenError):
    """A bug of the server, or an answer that this client cannot read."""

    default_code = StatusCode.INTERNAL


_NUMBERS = frozenset(map(int, StatusCode))
_CLASSES = {cls.default_code: cls for cls in ProcgenError.__subclasses__()}

# Control characters, of which a terminal would execute escape sequences.
_CONTROLS = {i: f"\\x{i:02x}" for i in (*range(0x20), *range(0x7F, 0xA0))}


def of_code(number: int, message: str) -> ProcgenError:
    """Returns the error for the number of a gRPC status code and a server's text.

    Control characters of the text are escaped.
    """
    code = StatusCode(number) if number in _NUMBERS else StatusCode.UNKNOWN
    return _CLASSES.get(code, ProcgenError)(message.translate(_CONTROLS), code)
