#!/usr/bin/env python3
"""Checks that all C++ files are formatted as by clang-format 14.

Usage: tests/tidy/format.py [--fix]. --fix formats the files.
Exit status: 0 formatted, 1 not formatted, 77 clang-format is not installed (CTest: skipped).
"""

import pathlib
import shutil
import subprocess
import sys

sys.dont_write_bytecode = True  # Set before the import below: no caches in the tree.
import source_tree  # noqa: E402

_NOT_INSTALLED = 77


def main(arguments):
    if arguments not in ([], ["--fix"]):
        print("Usage: tests/tidy/format.py [--fix]", file=sys.stderr)
        return 2
    # Prefer version 14: others format differently.
    program = shutil.which("clang-format-14") or shutil.which("clang-format")
    if program is None:
        print("clang-format is not installed; no file was checked")
        return _NOT_INSTALLED
    root = pathlib.Path(__file__).resolve().parents[2]
    files = [path for path in source_tree.list_files(root) if path.endswith((".h", ".cc"))]
    mode = ["-i"] if arguments else ["--dry-run", "-Werror"]
    status = subprocess.run([program, *mode, *files], cwd=root, check=False).returncode
    print(f"{len(files)} files; to format them all: tests/tidy/format.py --fix")
    return 1 if status else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
