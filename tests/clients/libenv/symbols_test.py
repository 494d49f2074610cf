#!/usr/bin/env python3
"""Checks that libenv.so exports exactly the functions of the interface.

Usage: symbols_test.py LIBENV. Exit status: 0 success, 1 failure, 77 nm is not installed (skipped).
"""

import shutil
import subprocess
import sys

INTERFACE = {"libenv_version", "libenv_make", "libenv_get_tensortypes", "libenv_set_buffers",
             "libenv_observe", "libenv_act", "libenv_close", "get_state", "set_state"}


def main(library):
    if shutil.which("nm") is None:
        print("nm is not installed; nothing was checked")
        return 77
    output = subprocess.run(["nm", "--dynamic", "--defined-only", library], capture_output=True,
                            check=True, text=True).stdout
    found = {line.split()[-1] for line in output.splitlines()}
    print("missing:", sorted(INTERFACE - found), "too many:", sorted(found - INTERFACE))
    return 0 if found == INTERFACE else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
