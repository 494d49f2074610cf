#!/usr/bin/env python3
"""Writes the manual pages of the package's commands and the completion of Bash, from their --help.

    deploy/package/make_manual.py SERVER MAKE_CREDENTIALS OUTPUT_FOLDER
"""

from __future__ import annotations

import gzip
import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple


class Flag(NamedTuple):
    name: str
    text: str
    default: str  # As --help prints it.


def _output(program: str, flag: str) -> str:
    return subprocess.run([program, flag], check=True, capture_output=True, text=True).stdout


def server_flags(text: str) -> list[Flag]:
    """The flags in Abseil's help."""
    flags = re.findall(r"^ +--(\w+) \((.*?)\);\s+default: (.*?);$", text, re.DOTALL | re.MULTILINE)
    return [Flag(name, " ".join(what.split()), default) for name, what, default in flags]


def _escape(text: str) -> str:
    escaped = text.replace("\\", r"\e").replace("-", r"\-").replace("'", r"\(aq")
    return re.sub(r"^\.", r"\\&.", escaped, flags=re.MULTILINE)


def _head(command: str, version: str, summary: str, synopsis: str) -> str:
    return (
        f'.TH {command.upper()} 1 "" "{version}" "User Commands"\n.SH NAME\n'
        f"{_escape(command)} \\- {_escape(summary)}\n.SH SYNOPSIS\n"
        f".B {_escape(command)}\n{_escape(synopsis)}\n"
    )


def server_page(text: str, version: str) -> str:
    """The page of the server, from the output of --help and --version."""
    summary = text.splitlines()[0].partition(": ")[2]
    page = _head("procgen-server", version, summary, "[--FLAG=VALUE]...") + ".SH OPTIONS\n"
    for flag in server_flags(text):
        default = flag.default if flag.default not in ("", '""') else "empty"
        page += f".TP\n.BI \\-\\-{flag.name} =VALUE\n{_escape(flag.text)}. Default: "
        page += f"{_escape(default)}\n"
    page += (
        ".TP\n.BI \\-\\-flagfile =FILE\nread flags from a file, one a line\n"
        ".TP\n.B \\-\\-help\nprint the flags and stop\n"
        ".TP\n.B \\-\\-version\nprint the version and stop\n"
        ".SH FILES\n.TP\n.I /etc/procgen\\-server/server.flags\nflags of the service\n"
    )
    return page + ".SH SEE ALSO\n.BR procgen\\-make\\-credentials (1)\n"


def credentials_page(text: str, version: str) -> str:
    """The page of the script, from the output of --help: usage and a paragraph."""
    usage, _, description = text.partition("\n\n")
    summary = "make a certificate authority, a server certificate and a token"
    page = _head("procgen-make-credentials", version, summary, usage.split(maxsplit=2)[2])
    page += f".SH DESCRIPTION\n{_escape(description)}"
    return page + ".SH SEE ALSO\n.BR procgen\\-server (1)\n"


def completion(text: str) -> str:
    """Completes flags, and file names for everything else."""
    names = [flag.name for flag in server_flags(text)]
    words = " ".join([f"--{name}=" for name in (*names, "flagfile")] + ["--help", "--version"])
    return f"""# Completion of procgen-server for Bash.
_procgen_server() {{
  [[ $2 == -* ]] || return
  COMPREPLY=($(compgen -W "{words}" -- "$2"))
  [[ ${{COMPREPLY[0]}} != *= ]] || compopt -o nospace
}}
complete -o default -F _procgen_server procgen-server
"""


def main(server: str, make_credentials: str, folder: Path) -> None:
    """Writes the files."""
    text = _output(server, "--help")
    version = _output(server, "--version").strip()
    pages = {
        "procgen-server": server_page(text, version),
        "procgen-make-credentials": credentials_page(_output(make_credentials, "--help"), version),
    }
    folder.mkdir(parents=True, exist_ok=True)
    for command, page in pages.items():
        (folder / f"{command}.1.gz").write_bytes(gzip.compress(page.encode(), mtime=0))
    (folder / "completion.bash").write_text(completion(text))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], Path(sys.argv[3]))
