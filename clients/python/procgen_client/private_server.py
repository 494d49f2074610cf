"""A server of this program's own, for whoever names none."""

from __future__ import annotations

import atexit
import os
import tempfile
import threading

from procgen_client.client import Client
from procgen_client.credentials import Credentials
from procgen_client.server_process import ServerProcess

# Address of the server to use where a program names none; without it a private one is started.
SERVER_VARIABLE = "PROCGEN_SERVER"


class _PrivateServer:
    """A server on a unix socket in a folder of its own."""

    def __init__(self) -> None:
        self.process_id = os.getpid()  # Who started it: after a fork, not the child.
        self._folder = tempfile.TemporaryDirectory(prefix="procgen-server-")
        try:
            self._process = ServerProcess(
                flags=["--drain_deadline=0s"],  # Who could save states ends with it.
                address=f"unix:{self._folder.name}/socket",
                log_path=os.path.join(self._folder.name, "log"),
                tied=True,
            )
        except BaseException:
            self._folder.cleanup()
            raise
        self.address = self._process.address

    def stop(self) -> None:
        if self.process_id == os.getpid():
            self._process.stop()
            self._folder.cleanup()


_lock = threading.Lock()
_server: _PrivateServer | None = None


def private_address() -> str:
    """Gives the address of this program's own server, which is started if it does not run yet.

    There is one for the whole program. It listens on a unix socket that only this user can reach,
    and ends with the program, however that ends.

    Raises:
        FileNotFoundError: There is no program procgen-server, as ServerProcess looks for it.
        UnavailableError: It ended at once.
    """
    global _server
    with _lock:
        if _server is None or _server.process_id != os.getpid():
            _server = _PrivateServer()
            atexit.register(_server.stop)
        return _server.address


def open_client(server: str | Client | None) -> Client:
    """Gives a client of a server.

    Args:
        server: An address; a client, which is given back; or None: what the variable PROCGEN_SERVER
            says, else this program's own server.

    Errors as Client and private_address.
    """
    if isinstance(server, Client):
        return server
    address = server or os.environ.get(SERVER_VARIABLE)
    # Nobody but this user reaches the own one: it asks for nothing, whatever the environment has.
    return Client(address) if address else Client(private_address(), credentials=Credentials())


def is_private(client: Client) -> bool:
    """Whether a client is of this program's own server, with which it shares memory."""
    return _server is not None and client.address == _server.address
