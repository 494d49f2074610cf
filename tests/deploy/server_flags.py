"""The flags that a deployment starts procgen-server with, and whether the program takes them."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Sequence
from pathlib import Path

from procgen_client.tools.server_process import BINARY_VARIABLE

_FLAG_FILE = "--flagfile="
# Wrong on purpose, so that the server reads all other flags, says so and ends.
_WRONG = "--log_level=whisper"


def expand(arguments: Sequence[str], files: dict[str, str]) -> list[str]:
    """Puts the lines of flag files in the place of --flagfile; `files` has texts by their paths."""
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
    """What flags say, by name without dashes; the last one counts."""
    pairs = (flag.removeprefix("--").partition("=") for flag in flags)
    return {name: value if equals else "true" for name, equals, value in pairs}


def complaint(flags: Sequence[str]) -> str:
    """What the server says against flags before it looks at their values together; "": nothing."""
    result = subprocess.run(
        [Path(os.environ[BINARY_VARIABLE]), *flags, _WRONG],
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode != 0
    return "" if "'whisper'" in result.stderr else result.stderr


def seconds(duration: str) -> float:
    """A duration as the flags have it, of one unit."""
    for unit, factor in (("ms", 0.001), ("s", 1), ("m", 60), ("h", 3600)):
        if duration.endswith(unit):
            return float(duration.removesuffix(unit)) * factor
    raise ValueError(f"{duration!r} is not a number with ms, s, m or h behind")
