"""TLS certificates and tokens of a client."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Union

from procgen_client.errors import NotFoundError

# Environment variables of the defaults: paths of PEM files, and the token itself.
CA_VARIABLE = "PROCGEN_SERVER_CA"
CERTIFICATE_VARIABLE = "PROCGEN_SERVER_CERTIFICATE"
KEY_VARIABLE = "PROCGEN_SERVER_KEY"
TOKEN_VARIABLE = "PROCGEN_SERVER_TOKEN"

Pem = Union[str, "os.PathLike[str]", bytes]


@dataclass(frozen=True)
class Credentials:
    """TLS certificates and token of a :class:`Client`. PEM is bytes, or the path of a file.

    Attributes:
        ca: The server's CA certificates; turns TLS on. None: plain text.
        certificate: The client certificate, for servers that require one; needs `key` and `ca`.
        key: The private key of `certificate`.
        token: Authenticates the caller on servers with tokens. Without TLS it is sent to this
            machine only (loopback, unix sockets), unless `token_in_plain_text`.
        token_in_plain_text: Sends the token to other machines without TLS, too.
    """

    ca: Pem | None = None
    certificate: Pem | None = field(default=None, repr=False)
    key: Pem | None = field(default=None, repr=False)
    token: str | None = field(default=None, repr=False)
    token_in_plain_text: bool = False

    @classmethod
    def from_environment(cls) -> Credentials:
        """Reads PROCGEN_SERVER_CA, _CERTIFICATE, _KEY (paths) and _TOKEN; each is optional."""
        return cls(
            ca=os.environ.get(CA_VARIABLE) or None,
            certificate=os.environ.get(CERTIFICATE_VARIABLE) or None,
            key=os.environ.get(KEY_VARIABLE) or None,
            token=os.environ.get(TOKEN_VARIABLE) or None,
        )

    def arguments(self) -> dict[str, Any]:
        """Returns the fields of _library.ConnectOptions, with the contents of files.

        Raises:
            NotFoundError: A file cannot be read.
        """
        return {
            "ca": _pem(self.ca, "ca"),
            "certificate": _pem(self.certificate, "certificate"),
            "key": _pem(self.key, "key"),
            "token": (self.token or "").encode() or None,
            "token_in_plain_text": self.token_in_plain_text,
        }


def _pem(given: Pem | None, name: str) -> bytes | None:
    if given is None or isinstance(given, bytes):
        return given or None
    try:
        return Path(given).read_bytes()
    except OSError as error:
        raise NotFoundError(f"{name} is {os.fspath(given)}: {error.strerror}") from None
