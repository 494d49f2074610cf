"""procgen-server as a child process."""

from __future__ import annotations

import os
import re
import selectors
import shutil
import signal
import subprocess
import time
import weakref
from collections.abc import Sequence
from pathlib import Path
from typing import IO

from procgen_client.errors import ServerNotFoundError, UnavailableError
from procgen_client.tools.art import Art, art_dir

# Path of the program. If unset, ServerProcess searches the places that its docstring lists.
BINARY_VARIABLE = "PROCGEN_SERVER_BINARY"
# This file is in clients/python/procgen_client/tools.
_CHECKOUT = os.path.normpath(Path(__file__).resolve().parent / "../../../..")
_CHECKOUT_BINARY = Path(_CHECKOUT) / "build/release/bin/procgen-server"

# Shell script that runs a program and stops it at the end of the shell's standard input, which is a
# pipe that the parent process holds. The program's standard input is empty, and standard output
# closes when the program ends.
_UNTIL_INPUT_ENDS = '"$@" </dev/null & exec >&-; read _; kill $! 2>/dev/null; wait $!'

# The server writes only its bound address to standard output.
_ADDRESS = re.compile(r"(unix:\S+|(?:[\w.-]+|\[[0-9a-fA-F:]+\]):\d+)\s*$")


class ServerProcess:
    """A procgen-server as a child process. A context manager: leaving it stops the server.

    By default it listens on loopback, on a port that the system chooses. It runs in a session of
    its own, so Ctrl-C does not reach it. It runs until stop is called; with `tied` also until this
    program ends.

    Attributes:
        address: Its address, for Client.
        process_id: Its process id; with `tied` that of the shell that watches it.
    """

    def __init__(
        self,
        binary: str | os.PathLike[str] | None = None,
        flags: Sequence[str] = (),
        *,
        workers: int | None = None,
        art: Art | None = None,
        web_address: str | None = None,
        address: str = "127.0.0.1:0",
        tied: bool = False,
        log_path: str | os.PathLike[str] | None = None,
        start_timeout: float = 30.0,
    ) -> None:
        """Starts the server and waits until it listens.

        Args:
            binary: Path of the program. None: the first of the environment variable
                PROCGEN_SERVER_BINARY, a release build of the checkout, and procgen-server in PATH.
            flags: More flags, e.g. ["--cluster=lab"]; see ``procgen-server --help``.
            workers: Threads that step environments. None: one for each core it may use.
            art: Folder of art to draw with, in the layout of Procgen 0.10.7; "procgen": that of the
                installed package `procgen`. None: the built-in art.
            web_address: HOST:PORT of its pages for browsers. None: no pages.
            address: HOST:PORT (port 0: the system chooses) or unix:PATH.
            tied: Stop it when this program ends, even after SIGKILL.
            log_path: File for its log. None: the log is discarded.
            start_timeout: Time to wait for it, in seconds.

        Raises:
            ServerNotFoundError: There is no such program.
            NotFoundError: There is no such art.
            UnavailableError: It ended, or did not listen in time. The message has the end of its
                log.
        """
        program = _find(binary)
        self._log_path = None if log_path is None else Path(log_path)
        named = {
            "address": address,
            "workers": workers,
            "art_dir": None if art is None else art_dir(art),
            "web_address": web_address,
        }
        given = [f"--{name}={value}" for name, value in named.items() if value is not None]
        command = [program, *given, *flags]
        if tied:
            command = ["/bin/sh", "-c", _UNTIL_INPUT_ENDS, "procgen-server", *command]
        with open(log_path or os.devnull, "wb") as log:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE if tied else subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=log,
                start_new_session=True,
            )
        _running.add(self)
        self.process_id = self._process.pid
        try:
            assert self._process.stdout is not None
            self.address = self._wait_for_address(self._process.stdout, start_timeout)
        except BaseException:
            self.stop()
            raise

    def __enter__(self) -> ServerProcess:
        """Returns the process itself."""
        return self

    def __exit__(self, *exception: object) -> None:
        """Stops the server."""
        self.stop()

    def stop(self, *, timeout: float = 15.0) -> int:
        """Lets the server drain and end, and waits; kills it after `timeout` seconds.

        Returns:
            Its exit status; the same if called again.
        """
        self._ask_to_end()
        try:
            return self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            os.killpg(self.process_id, signal.SIGKILL)  # The session, including a shell.
            return self._process.wait()
        finally:
            if self._process.stdout is not None:
                self._process.stdout.close()

    def _abandon(self) -> None:
        """In a forked child: closes the pipes, so that only the parent's end stops the server."""
        for end in (self._process.stdin, self._process.stdout):
            if end is not None:
                end.close()

    def _ask_to_end(self) -> None:
        if self._process.stdin is not None:
            self._process.stdin.close()
        elif self._process.poll() is None:
            os.killpg(self.process_id, signal.SIGTERM)  # The session, including a shell.

    def _wait_for_address(self, output: IO[bytes], timeout: float) -> str:
        deadline = time.monotonic() + timeout
        text = b""
        with selectors.DefaultSelector() as selector:
            selector.register(output, selectors.EVENT_READ)
            while selector.select(max(0.0, deadline - time.monotonic())):
                piece = os.read(output.fileno(), 4096)
                if not piece:
                    self._ask_to_end()
                    status = self._process.wait()
                    raise UnavailableError(
                        f"procgen-server ended with status {status}{self._last_words()}"
                    )
                text += piece
                for line in text.decode(errors="replace").splitlines(keepends=True):
                    match = _ADDRESS.search(line)
                    if match and line.endswith("\n"):
                        return match.group(1)
        raise UnavailableError(
            f"procgen-server did not listen within {timeout:g} s{self._last_words()}"
        )

    def _last_words(self) -> str:
        if self._log_path is None or not self._log_path.is_file():
            return ""
        lines = self._log_path.read_text(errors="replace").splitlines()[-5:]
        return "; its log ends with:\n" + "\n".join(lines) if lines else ""


_running: weakref.WeakSet[ServerProcess] = weakref.WeakSet()


def _after_fork_in_child() -> None:
    for process in list(_running):
        process._abandon()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork_in_child)


def _find(binary: str | os.PathLike[str] | None) -> str:
    """Returns the path of the program; the error lists what was tried."""
    chosen = binary or os.environ.get(BINARY_VARIABLE)
    tried = (
        [os.fspath(chosen)]
        if chosen
        else [str(_CHECKOUT_BINARY), "procgen-server"]
    )
    for program in tried:
        found = shutil.which(program)
        if found is not None:
            return os.fspath(found)
    raise ServerNotFoundError(
        f"there is no server program; tried: {', '.join(tried)}. Install the Debian package, build "
        f"a checkout (deploy/quickstart.sh), set {BINARY_VARIABLE} to the program, or give the "
        "address of a running server (server=HOST:PORT)"
    )
