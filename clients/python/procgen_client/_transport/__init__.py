"""Connections to a server: by the native module, or by grpcio where that is missing.

Both have the classes of `_native.pyi`. The environment variable PROCGEN_CLIENT_TRANSPORT selects
"native" or "grpcio"; PROCGEN_CLIENT_NATIVE is the folder of a native module in a build tree.
"""

from __future__ import annotations

import importlib.machinery
import importlib.util
import os
import warnings
from types import ModuleType
from typing import TYPE_CHECKING, Any

import procgen_client

if TYPE_CHECKING:
    from procgen_client._native import Connection

TRANSPORT_VARIABLE = "PROCGEN_CLIENT_TRANSPORT"
NATIVE_FOLDER_VARIABLE = "PROCGEN_CLIENT_NATIVE"

_module: ModuleType | None = None
_forked_from: ModuleType | None = None  # The module that the parent process loaded.


def is_native() -> bool:
    """Whether the native module is installed and not disabled."""
    return os.environ.get(TRANSPORT_VARIABLE) != "grpcio" and _native() is not None


def open_connection(address: str, **arguments: Any) -> Connection:  # noqa: ANN401
    """Connects; arguments as _native.Connection, errors as :class:`procgen_client.Client`."""
    if is_native():
        module = _native()
        assert module is not None
        connection: Connection = module.Connection(address, **arguments)
        return connection
    from procgen_client._transport import grpc_fallback

    return grpc_fallback.open_connection(address, **arguments)


def _native() -> ModuleType | None:
    global _module
    if _module is not None:
        return _module
    if _forked_from is not None:
        _module = _load_again(_forked_from)
        return _module
    folder = os.environ.get(NATIVE_FOLDER_VARIABLE)
    if folder and folder not in procgen_client.__path__:
        procgen_client.__path__.insert(0, folder)
    try:
        from procgen_client import _native as module
    except ImportError as error:
        if os.environ.get(TRANSPORT_VARIABLE) == "native":
            raise
        if error.name == "_native":  # The module exists, but one of its libraries is missing.
            warnings.warn(f"grpcio is used because of: {error}", RuntimeWarning, stacklevel=2)
        return None
    _module = module
    return _module


def _load_again(module: ModuleType) -> ModuleType:
    """Loads another copy of the module, whose gRPC has not been forked.

    The loader reuses a file that it has loaded before, so the copy is loaded from a memfd.
    """
    assert module.__file__ is not None
    memory = os.memfd_create(os.path.basename(module.__file__))
    try:
        with open(module.__file__, "rb") as file:
            os.sendfile(memory, file.fileno(), 0, os.fstat(file.fileno()).st_size)
        path = f"/proc/{os.getpid()}/fd/{memory}"
        loader = importlib.machinery.ExtensionFileLoader(module.__name__, path)
        spec = importlib.util.spec_from_file_location(module.__name__, path, loader=loader)
        assert spec is not None
        copy = importlib.util.module_from_spec(spec)
        copy.__file__ = module.__file__
        return copy
    finally:
        os.close(memory)


def _after_fork_in_child() -> None:
    global _module, _forked_from
    if _module is not None:
        _module, _forked_from = None, _module


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork_in_child)
