"""TLS certificates and tokens of a client."""

from __future__ import annotations

import ipaddress
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Union

from procgen_client.errors import InvalidArgumentError, NotFoundError

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

    def check(self, address: str) -> None:
        """Validates the credentials for `address`.

        Raises:
            InvalidArgumentError: A certificate without its key or without `ca`; or a token with
                white space, or that would be sent to another machine in plain text.
        """
        if (self.certificate is None) != (self.key is None):
            raise InvalidArgumentError(
                "a client certificate or its key is given alone; give both or none"
            )
        if self.token and len(self.token.split()) != 1:
            raise InvalidArgumentError(
                "the token contains white space; of a line 'OWNER TOKEN' of the server's file it "
                "is the second word"
            )
        if self.ca is not None:
            return
        if self.certificate is not None:
            raise InvalidArgumentError(
                "a client certificate is given without the server's CA certificates; give ca, or "
                f"set {CA_VARIABLE}"
            )
        if self.token and not self.token_in_plain_text and not is_this_machine(address):
            raise InvalidArgumentError(
                f"the token would go to {address} in plain text; give the server's CA certificates "
                f"(ca, or {CA_VARIABLE}), or set token_in_plain_text"
            )

    def arguments(self, address: str) -> dict[str, Any]:
        """Returns the arguments of a connection, with the contents of files.

        Raises:
            InvalidArgumentError: As check.
            NotFoundError: A file cannot be read.
        """
        self.check(address)
        return {
            "ca": _pem(self.ca, "ca"),
            "certificate": _pem(self.certificate, "certificate"),
            "key": _pem(self.key, "key"),
            "token": self.token or "",
            "token_in_plain_text": self.token_in_plain_text,
        }


def is_this_machine(address: str) -> bool:
    """Whether all of `address` is loopback or unix sockets, where plain text is safe."""
    if "," in address:
        return all(is_this_machine(each) for each in address.split(","))
    if address.startswith("unix:"):
        return True
    host = address.rpartition(":")[0].removeprefix("dns:///")
    if host.lower() == "localhost":
        return True
    try:
        # Parsed as a whole, because "127.0.0.1.example.com" is a host name.
        return ipaddress.ip_address(host.removeprefix("[").removesuffix("]")).is_loopback
    except ValueError:
        return False


def _pem(given: Pem | None, name: str) -> bytes:
    if given is None or isinstance(given, bytes):
        return given or b""
    try:
        return Path(given).read_bytes()
    except OSError as error:
        raise NotFoundError(f"{name} is {os.fspath(given)}: {error.strerror}") from None
