"""The server's flags in deployments, and whether procgen-server accepts them."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Sequence
from pathlib import Path

from procgen_client.tools.server_process import BINARY_VARIABLE

_FLAG_FILE = "--flagfile="
# Invalid on purpose: the server parses all other flags, reports this one and exits.
_WRONG = "--log_level=whisper"


def expand(arguments: Sequence[str], files: dict[str, str]) -> list[str]:
    """Replaces --flagfile by the lines of the file; `files`: contents by path."""
    flags = []
    for argument in arguments:
        if argument.startswith(_FLAG_FILE):
            for path in argument.removeprefix(_FLAG_FILE).split(","):
                lines = (line.strip() for line in files[path].splitlines())
                flags += [line for line in lines if line and not line.startswith("#")]
        else:
            flags.append(argument)
    return flags


def values(flags: Sequence[str]) -> dict[str, str]:
    """Returns the values of flags by name without dashes; the last one wins."""
    pairs = (flag.removeprefix("--").partition("=") for flag in flags)
    return {name: value if equals else "true" for name, equals, value in pairs}


def complaint(flags: Sequence[str]) -> str:
    """Returns the server's error for flags, checked one by one; "" if there is none."""
    result = subprocess.run(
        [Path(os.environ[BINARY_VARIABLE]), *flags, _WRONG],
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode != 0
    return "" if "'whisper'" in result.stderr else result.stderr
