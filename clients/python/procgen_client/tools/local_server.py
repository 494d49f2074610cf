"""Local servers, for programs that give no address."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
import threading

from procgen_client._transport import is_native
from procgen_client.client import Client
from procgen_client.credentials import Credentials
from procgen_client.errors import InvalidArgumentError
from procgen_client.tools.server_process import ServerProcess

# Address of the default server. If unset, a local server is started.
SERVER_VARIABLE = "PROCGEN_SERVER"


class _LocalServer:
    """A server on a unix socket in a temporary folder."""

    def __init__(self, art_dir: str) -> None:
        self._process_id = os.getpid()
        self._folder = tempfile.mkdtemp(prefix="procgen-server-")
        try:
            self._process = ServerProcess(
                # No drain time: its only client is this program.
                flags=["--drain_timeout=0s", *([f"--art_dir={art_dir}"] if art_dir else [])],
                address=f"unix:{self._folder}/socket",
                log_path=os.path.join(self._folder, "log"),
                tied=True,
            )
        except BaseException:
            shutil.rmtree(self._folder, ignore_errors=True)
            raise
        self.address = self._process.address

    def stop(self) -> None:
        """Stops the server; in a forked child does nothing."""
        if self._process_id == os.getpid():
            self._process.stop()
            shutil.rmtree(self._folder, ignore_errors=True)


_lock = threading.Lock()
_servers: dict[str, _LocalServer] = {}  # By their art_dir.


def local_address(art_dir: str = "") -> str:
    """Starts the program's local server if it is not running, and returns its address.

    A program has one local server, and one more for each folder of art. A forked child has separate
    ones. The server listens on a unix socket that only this user can reach, and stops with the
    program, even after SIGKILL.

    Args:
        art_dir: Folder of the art to render with. Empty: the built-in art.

    Raises:
        ServerNotFoundError: ServerProcess finds no procgen-server.
        UnavailableError: The server ended at once.
    """
    with _lock:
        if art_dir not in _servers:
            _servers[art_dir] = _LocalServer(art_dir)
            atexit.register(_servers[art_dir].stop)
        return _servers[art_dir].address


def open_client(
    server: str | Client | None, art_dir: str | os.PathLike[str] | None = None
) -> Client:
    """Returns a client of a server.

    Args:
        server: An address; a client, which is returned; or None: the address in the variable
            PROCGEN_SERVER, else the local server.
        art_dir: Folder of the local server's art. None: the built-in art.

    Raises:
        InvalidArgumentError: `art_dir` is given, and the server is not a local server.
        ProcgenError: As Client and local_address.
    """
    address = None if isinstance(server, Client) else server or os.environ.get(SERVER_VARIABLE)
    if art_dir is not None and (isinstance(server, Client) or address):
        where = server.address if isinstance(server, Client) else address
        raise InvalidArgumentError(
            f"the art is {os.fspath(art_dir)}, but the server at {where} chooses its art "
            "by its flag --art_dir"
        )
    if isinstance(server, Client):
        return server
    if address:
        return Client(address)
    # A local server requires no credentials, so those of the environment are not used.
    folder = "" if art_dir is None else os.path.abspath(os.fspath(art_dir))
    return Client(local_address(folder), credentials=Credentials())


def is_local(client: Client) -> bool:
    """Whether a client is connected to a local server and can share memory with it."""
    return is_native() and any(client.address == server.address for server in _servers.values())


def _forget() -> None:
    """In a forked child: forgets the parent's servers."""
    global _lock
    _lock = threading.Lock()
    _servers.clear()


os.register_at_fork(after_in_child=_forget)
