#!/usr/bin/env python3
"""Builds minimal.c against an installed libprocgen, by find_package and by pkg-config; and
minimal_remote.c against libprocgen_remote.

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
find_package(procgen 0.9 REQUIRED)
add_executable(minimal minimal.c)
target_link_libraries(minimal PRIVATE procgen::procgen)
add_executable(minimal_remote minimal_remote.c)
target_link_libraries(minimal_remote PRIVATE procgen::remote)
"""
# What the library may need: the C library, in its parts, and GCC's unwinder.
_SYSTEM = {"linux-vdso.so.1", "libc.so.6", "libm.so.6", "libgcc_s.so.1", "ld-linux-x86-64.so.2"}
_GLIBC_MAX = (2, 34)  # of RHEL 9; Ubuntu 22.04 has 2.35, Debian 12 has 2.36


def _run(*command: str | Path, **variables: str) -> str:
    return subprocess.run(
        command, check=True, stdout=subprocess.PIPE, text=True, env={**os.environ, **variables}
    ).stdout


def _check_exports(library: Path, *headers: Path) -> None:
    """The library exports what the headers declare, and nothing else."""
    symbols = _run("nm", "--dynamic", "--defined-only", library).splitlines()
    exported = {line.split()[-1] for line in symbols}
    text = "".join(re.sub(r"//.*", "", header.read_text()) for header in headers)
    declared = set(re.findall(r"\b(procgen_\w+)\(", text))
    assert exported == declared, exported ^ declared


def _build_by_pkg_config(name: str, package: str, folder: Path, pkgconfig: Path) -> Path:
    flags = _run("pkg-config", "--cflags", "--libs", package,
                 PKG_CONFIG_PATH=str(pkgconfig)).split()  # fmt: skip
    program = folder / name
    _run("cc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic",
         folder / f"{name}.c", *flags, "-o", program)  # fmt: skip
    return program


def main(build: str, cmake: str) -> None:
    """Installs into a folder of its own and tries both ways."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        prefix = folder / "installed"
        _run(cmake, "--install", build, "--prefix", prefix, "--component", "development")
        (library,) = prefix.glob("**/libprocgen.so")
        needed = {Path(path).name for path in re.findall(r"^\s*(\S+)", _run("ldd", library), re.M)}
        assert needed <= _SYSTEM, needed
        imported = _run("nm", "--dynamic", "--undefined-only", library)
        versions = set(re.findall(r"@GLIBC_(\d+)\.(\d+)", imported))
        assert versions, imported
        assert max((int(a), int(b)) for a, b in versions) <= _GLIBC_MAX, imported
        header = prefix / "include/procgen/procgen.h"
        _check_exports(library, header)
        _check_exports(library.with_name("libprocgen_remote.so.1"), header,
                       header.with_name("procgen_remote.h"))  # fmt: skip

        (folder / "CMakeLists.txt").write_text(_PROJECT)
        for name in ("minimal.c", "minimal_remote.c"):
            (folder / name).write_text((_HERE / name).read_text())
        _run(cmake, "-S", folder, "-B", folder / "build", f"-DCMAKE_PREFIX_PATH={prefix}")
        _run(cmake, "--build", folder / "build")
        assert "pixels drawn" in _run(folder / "build/minimal")
        assert "no server listens" in _run(folder / "build/minimal_remote")

        (pkgconfig,) = prefix.glob("**/pkgconfig")
        libraries = str(library.parent)
        program = _build_by_pkg_config("minimal", "procgen", folder, pkgconfig)
        output = _run(program, LD_LIBRARY_PATH=libraries)
        assert "pixels drawn" in output, output
        program = _build_by_pkg_config("minimal_remote", "procgen_remote", folder, pkgconfig)
        output = _run(program, LD_LIBRARY_PATH=libraries)
        assert "no server listens" in output, output


if __name__ == "__main__":
    main(*sys.argv[1:])
