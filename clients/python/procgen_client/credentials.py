"""How a client knows its server, and what it shows to it."""

from __future__ import annotations

import ipaddress
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from procgen_client.errors import InvalidArgumentError, NotFoundError

# Where to look if nobody says: paths of PEM files, and the token itself.
CA_VARIABLE = "PROCGEN_SERVER_CA"
CERTIFICATE_VARIABLE = "PROCGEN_SERVER_CERTIFICATE"
KEY_VARIABLE = "PROCGEN_SERVER_KEY"
TOKEN_VARIABLE = "PROCGEN_SERVER_TOKEN"

Pem = str | os.PathLike[str] | bytes


@dataclass(frozen=True)
class Credentials:
    """What :class:`Client` connects with. PEM is given as bytes, or as the path of a file.

    Attributes:
        ca: Certificates that vouch for the server. Given: TLS is spoken. None: plain text.
        certificate: The client's own, for servers that ask for one; with `key` and `ca`.
        key: The key of `certificate`.
        token: Authenticates the caller on servers with tokens. Without TLS it is sent to this
            machine only (loopback, unix sockets), unless `token_in_plain_text`.
        token_in_plain_text: Send the token to other machines without TLS, too.
    """

    ca: Pem | None = None
    certificate: Pem | None = field(default=None, repr=False)
    key: Pem | None = field(default=None, repr=False)
    token: str | None = field(default=None, repr=False)
    token_in_plain_text: bool = False

    @classmethod
    def from_environment(cls) -> Credentials:
        """What PROCGEN_SERVER_CA, _CERTIFICATE, _KEY (paths) and _TOKEN say, if they are there."""
        return cls(
            ca=os.environ.get(CA_VARIABLE) or None,
            certificate=os.environ.get(CERTIFICATE_VARIABLE) or None,
            key=os.environ.get(KEY_VARIABLE) or None,
            token=os.environ.get(TOKEN_VARIABLE) or None,
        )

    def check(self, address: str) -> None:
        """Checks that `address` can be connected to with them.

        Raises:
            InvalidArgumentError: A certificate without its key or without `ca`, or a token that
                would be sent to another machine in plain text.
        """
        if (self.certificate is None) != (self.key is None):
            raise InvalidArgumentError(
                "a client's certificate or its key is given alone; give both or none"
            )
        if self.ca is not None:
            return
        if self.certificate is not None:
            raise InvalidArgumentError(
                "a client's certificate is given without certificates that vouch for the server; "
                f"give ca, or set {CA_VARIABLE}"
            )
        if self.token and not self.token_in_plain_text and not is_this_machine(address):
            raise InvalidArgumentError(
                f"the token would go to {address} in plain text; give certificates that vouch for "
                f"the server (ca, or {CA_VARIABLE}), or say token_in_plain_text"
            )

    def arguments(self, address: str) -> dict[str, Any]:
        """Gives them as a connection to `address` takes them, files read.

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
    """Whether nobody else can listen on the way to `address`."""
    if address.startswith("unix:"):
        return True
    host = address.rpartition(":")[0].removeprefix("dns:///")
    if host.lower() == "localhost":
        return True
    try:
        # By its exact form: "127.0.0.1.example.com" is a name.
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
