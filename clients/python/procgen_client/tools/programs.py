"""The programs of the wheel: each console script replaces itself by the bundled program."""

from __future__ import annotations

import os
import sys
from pathlib import Path

# Programs that the wheel brings. Absent in a pure wheel and in a checkout.
FOLDER = Path(__file__).resolve().parent.parent / "bin"


def run() -> None:
    """Runs the program that has the name of this script, with its arguments."""
    program = FOLDER / Path(sys.argv[0]).name
    os.execv(program, [str(program), *sys.argv[1:]])
