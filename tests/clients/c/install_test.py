#!/usr/bin/env python3
"""Builds minimal.c against an installed libprocgen, by find_package and by pkg-config.

Usage: install_test.py BUILD_FOLDER CMAKE
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

_HERE = Path(__file__).resolve().parent
_PROJECT = """
cmake_minimum_required(VERSION 3.25)
project(minimal C)
set(CMAKE_C_STANDARD 99)
find_package(procgen 0.1 REQUIRED)
add_executable(minimal minimal.c)
target_link_libraries(minimal PRIVATE procgen::procgen)
"""
# What the library may need: the C library, in its parts.
_SYSTEM = {"linux-vdso.so.1", "libc.so.6", "libm.so.6", "ld-linux-x86-64.so.2"}


def _run(*command: str | Path, **variables: str) -> str:
    return subprocess.run(
        command, check=True, stdout=subprocess.PIPE, text=True, env={**os.environ, **variables}
    ).stdout


def main(build: str, cmake: str) -> None:
    """Installs into a folder of its own and tries both ways."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        prefix = folder / "installed"
        _run(cmake, "--install", build, "--prefix", prefix, "--component", "development")
        (library,) = prefix.glob("**/libprocgen.so")
        needed = {Path(path).name for path in re.findall(r"^\s*(\S+)", _run("ldd", library), re.M)}
        assert needed <= _SYSTEM, needed
        symbols = _run("nm", "--dynamic", "--defined-only", library).splitlines()
        exported = {line.split()[-1] for line in symbols}
        header = (prefix / "include/procgen/procgen.h").read_text()
        declared = set(re.findall(r"\b(procgen_\w+)\(", re.sub(r"//.*", "", header)))
        assert exported == declared, exported ^ declared

        (folder / "CMakeLists.txt").write_text(_PROJECT)
        (folder / "minimal.c").write_text((_HERE / "minimal.c").read_text())
        _run(cmake, "-S", folder, "-B", folder / "build", f"-DCMAKE_PREFIX_PATH={prefix}")
        _run(cmake, "--build", folder / "build")
        assert "pixels drawn" in _run(folder / "build/minimal")

        (pkgconfig,) = prefix.glob("**/pkgconfig")
        flags = _run("pkg-config", "--cflags", "--libs", "procgen",
                     PKG_CONFIG_PATH=str(pkgconfig)).split()  # fmt: skip
        program = folder / "minimal"
        _run("cc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic",
             folder / "minimal.c", *flags, "-o", program)  # fmt: skip
        output = _run(program, LD_LIBRARY_PATH=str(library.parent))
        assert "pixels drawn" in output, output


if __name__ == "__main__":
    main(*sys.argv[1:])
