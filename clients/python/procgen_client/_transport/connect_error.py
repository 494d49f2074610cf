"""Explains why grpcio cannot connect, in the words of the C++ client's connect_error.cc."""

from __future__ import annotations

import ssl

from procgen_client._transport.address import dial

# What to do, by a part of gRPC's reason for a failed connection with TLS.
_WITH_TLS = {
    "wrong version number": "the server does not use TLS: give no CA certificates (unset "
    "PROCGEN_SERVER_CA), or start it with --tls_certificate and --tls_key",
    "certificate verify failed": "the server's certificate is not signed by the given CA "
    "certificates (PROCGEN_SERVER_CA), or has expired: give those of the authority that signed it",
    "is not in peer certificate": "the server's certificate is for other names: connect by a name "
    "or an address that is in it",
}
_REQUIRES_TLS = (
    "the server requires TLS: give its CA certificates (the variable PROCGEN_SERVER_CA is the path "
    "of their PEM file)"
)


def explain(address: str, reason: str, *, uses_tls: bool) -> str:
    """Returns why waiting cannot help, and what to do; empty: the server may still be starting."""
    if uses_tls:
        said = reason.replace("_", " ").lower()  # BoringSSL: CERTIFICATE_VERIFY_FAILED.
        found = [text for part, text in _WITH_TLS.items() if part in said]
    else:
        found = [_REQUIRES_TLS] if _is_closed(reason) and _accepts_tls(address) else []
    return f"{found[0]} ({reason})" if found else ""


def likely_cause(reason: str, *, uses_tls: bool) -> str:
    """Returns what may cause an error that `explain` cannot explain; empty: unknown."""
    if not _is_closed(reason):
        return ""
    if uses_tls:
        return (
            "; the server may require a client certificate (PROCGEN_SERVER_CERTIFICATE, "
            "PROCGEN_SERVER_KEY)"
        )
    return "; the server may require TLS (PROCGEN_SERVER_CA) and a client certificate"


def _is_closed(reason: str) -> bool:
    parts = ("Socket closed", "Connection reset by peer", "handshaker shutdown")
    return any(part in reason for part in parts)


def _accepts_tls(address: str) -> bool:
    """Whether the server accepts a connection with TLS. Verifies nothing."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    context.set_alpn_protocols(["h2"])
    try:
        with dial(address) as line, context.wrap_socket(line):
            return True
    except (OSError, ValueError):
        return False
