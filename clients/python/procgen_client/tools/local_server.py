"""Local servers, for programs that give no address."""

from __future__ import annotations

import atexit
import hashlib
import os
import shutil
import socket
import stat
import tempfile
import threading
from pathlib import Path
from typing import IO

from procgen_client.client import Client
from procgen_client.credentials import Credentials
from procgen_client.errors import FailedPreconditionError, InvalidArgumentError
from procgen_client.tools.art import ART_VARIABLE, Art, art_dir
from procgen_client.tools.server_process import ServerProcess

# Address of the default server. If unset, a local server is started.
SERVER_VARIABLE = "PROCGEN_SERVER"


class _LocalServer:
    """A server on a unix socket in a temporary folder, for one program."""

    def __init__(self, art: str) -> None:
        self._process_id = os.getpid()
        self._folder = Path(tempfile.mkdtemp(prefix="procgen-server-"))
        try:
            self._process = _start(self._folder, art)
        except BaseException:
            shutil.rmtree(self._folder, ignore_errors=True)
            raise
        self.address = self._process.address

    def stop(self) -> None:
        """Stops the server; in a forked child does nothing."""
        if self._process_id == os.getpid():
            self._process.stop()
            shutil.rmtree(self._folder, ignore_errors=True)


class _JobServer:
    """The server that the ranks of a job on this host share. The first rank starts it.

    The ranks agree on a folder. Each holds a shared lock on its file ``ranks``, which ends with the
    rank. A shell waits for an exclusive lock, stops the server and removes the folder. So a rank
    that joins during that waits, finds that its files are gone, and begins again.
    """

    def __init__(self, job: str, art: str) -> None:
        name = hashlib.sha256(f"{job}\n{art}".encode()).hexdigest()[:16]
        folder = Path(tempfile.gettempdir()) / f"procgen-server-{os.getuid()}-{name}"
        self.address = f"unix:{folder}/socket"
        while True:
            _make_private(folder)
            start = _locked(folder / "start", shared=False)  # One rank at a time looks and starts.
            ranks = _locked(folder / "ranks", shared=True)
            if start is not None and ranks is not None:
                break
        self._ranks = ranks
        with start:
            if not _is_served(folder / "socket"):
                self._process = _start(folder, art, ranks=folder)

    def stop(self) -> None:
        """Ends this rank's use of the server."""
        self._ranks.close()


def _start(folder: Path, art: str, ranks: Path | None = None) -> ServerProcess:
    return ServerProcess(
        flags=["--drain_timeout=0s"],  # Its only clients are the programs that it ends with.
        art=art or None,
        address=f"unix:{folder}/socket",
        log_path=folder / "log",
        tied=ranks is None,
        ranks=ranks,
    )


def _make_private(folder: Path) -> None:
    """Makes the folder; an existing one must be this user's alone."""
    folder.mkdir(mode=0o700, exist_ok=True)
    facts = folder.lstat()
    if not stat.S_ISDIR(facts.st_mode) or facts.st_uid != os.getuid() or facts.st_mode & 0o077:
        raise FailedPreconditionError(
            f"{folder} belongs to another user or is open to others: remove it, or set TMPDIR"
        )


def _locked(path: Path, *, shared: bool) -> IO[bytes] | None:
    """Opens and locks a file; None: it was removed meanwhile."""
    import fcntl  # Not every system has it; those without have no ranks.

    try:
        file = open(path, "ab")
        fcntl.flock(file, fcntl.LOCK_SH if shared else fcntl.LOCK_EX)
        if os.path.samestat(os.fstat(file.fileno()), os.stat(path)):
            return file
    except FileNotFoundError:
        pass
    return None


def _is_served(path: Path) -> bool:
    with socket.socket(socket.AF_UNIX) as line:
        return line.connect_ex(str(path)) == 0


def _job() -> str:
    """What the ranks of a job on this host have in common; empty: this program is no rank."""
    variables = os.environ
    if os.name != "posix" or shutil.which("flock") is None:
        return ""
    if "LOCAL_WORLD_SIZE" in variables and "TORCHELASTIC_RUN_ID" in variables:
        return f"torchrun {os.getppid()}"
    if "SLURM_JOB_ID" in variables and "SLURM_STEP_ID" in variables:
        return f"slurm {variables['SLURM_JOB_ID']}.{variables['SLURM_STEP_ID']}"
    return ""


_lock = threading.Lock()
_servers: dict[str, _LocalServer | _JobServer] = {}  # By their folder of art.


def local_address(art: Art | None = None) -> str:
    """Starts the program's local server if it is not running, and returns its address.

    A program has one local server, and one more for each folder of art. Programs that torchrun or a
    SLURM job step started on one host share them. A forked child has separate ones. The server
    listens on a unix socket that only this user can reach, and stops with the (last) program, even
    after SIGKILL.

    Args:
        art: The art to draw with, as for ServerProcess. None: that of the variable
            PROCGEN_SERVER_ART, else the built-in art.

    Raises:
        NotFoundError: There is no such art.
        ServerNotFoundError: ServerProcess finds no procgen-server.
        UnavailableError: The server ended at once.
    """
    art = art or os.environ.get(ART_VARIABLE)
    folder = "" if not art else art_dir(art)
    with _lock:
        if folder not in _servers:
            job = _job()
            _servers[folder] = _JobServer(job, folder) if job else _LocalServer(folder)
            atexit.register(_servers[folder].stop)
        return _servers[folder].address


def open_client(server: str | Client | ServerProcess | None, art: Art | None = None) -> Client:
    """Returns a client of a server.

    Args:
        server: An address or a ServerProcess; a client, which is returned; or None: the address in
            the variable PROCGEN_SERVER, else the local server.
        art: The local server's art, as for local_address.

    Raises:
        InvalidArgumentError: `art` is given, and the server is not a local server.
        ProcgenError: As Client and local_address.
    """
    given = os.environ.get(SERVER_VARIABLE) if server is None else server
    address = given.address if isinstance(given, Client | ServerProcess) else given
    if art is not None and address:
        raise InvalidArgumentError(
            f"art is {os.fspath(art)}, but the server at {address} chooses its art by its flag "
            "--art_dir: give no server, or ServerProcess(art=...)"
        )
    if isinstance(server, Client):
        return server
    if address:
        return Client(address)
    # A local server requires no credentials, so those of the environment are not used.
    return Client(local_address(art), credentials=Credentials())


def is_local(client: Client) -> bool:
    """Whether a client is connected to a local server."""
    return any(client.address == server.address for server in _servers.values())


def _forget() -> None:
    """In a forked child: forgets the parent's servers."""
    global _lock
    _lock = threading.Lock()
    _servers.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
