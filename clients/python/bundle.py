"""Builds the libraries of a wheel and copies them into it, with the libraries that they need.

Libraries of the C library and of GCC's runtime stay the system's. All others are copied under names
of their own, so that they do not collide with other copies in a process.
"""

from __future__ import annotations

import hashlib
import importlib.util
import pathlib
import platform
import re
import shutil
import subprocess
import sys

LIBRARY = "libprocgen.so.1"
REMOTE_LIBRARY = "libprocgen_remote.so.1"  # optional
_REMOTE_TARGET = "procgen_remote"

_SYSTEM_LIBRARIES = re.compile(
    r"(linux-vdso|ld-linux-[\w-]+|libc|libm|libdl|librt|libpthread|libstdc\+\+|libgcc_s)\.so"
)
# The oldest glibc beside which distributions have this version of GCC's C++ runtime or a newer one.
_GLIBC_OF_RUNTIME = {(3, 4, 29): (2, 34), (3, 4, 30): (2, 35)}
_TOOLS = {
    "cmake": "cmake",
    "ninja": "ninja-build",
    "c++": "g++",
    "rsvg-convert": "librsvg2-bin",
}
# Debian packages whose code libprocgen contains.
_STATIC_PACKAGES = ("libabsl-dev", "libstb-dev", "nlohmann-json3-dev", "zlib1g-dev")


def require_tools(package_of: dict[str, str]) -> None:
    """Exits with a message if tools are missing. `package_of`: Debian package of each tool."""
    missing = [tool for tool in package_of if shutil.which(tool) is None]
    if missing:
        packages = " ".join(sorted({package_of[tool] for tool in missing}))
        sys.exit(
            f"error: building the wheel needs {', '.join(missing)}; on Debian: apt install "
            f"{packages}, or clients/python/build_wheel.sh, which installs them"
        )


def build(checkout: pathlib.Path, machine: str, with_remote: bool) -> pathlib.Path:
    """Builds the libraries of `checkout` and returns their folder.

    Args:
        checkout: The checkout.
        machine: As `uname -m` names it; another one than this is cross-compiled.
        with_remote: Whether to build the library for servers, too.
    """
    require_tools(_TOOLS)
    is_native = machine == platform.machine()
    if with_remote and not is_native:
        sys.exit("error: the library for servers cannot be cross-compiled")
    preset = "release" if with_remote else "library" if is_native else f"library-{machine}"
    targets = ["procgen_c", *([_REMOTE_TARGET] if with_remote else [])]
    _run("cmake", "--preset", preset, cwd=checkout)
    _run("cmake", "--build", checkout / "build" / preset, "--target", *targets, cwd=checkout)
    return checkout / "build" / preset / "lib"


def copy_libraries(built: pathlib.Path, package: pathlib.Path, machine: str) -> None:
    """Copies the libraries in the folder `built`, and what they need, into the folder `package`."""
    names = [name for name in (LIBRARY, REMOTE_LIBRARY) if (built / name).exists()]
    if LIBRARY not in names:
        sys.exit(f"error: there is no {built / LIBRARY}")
    for name in names:
        shutil.copy2(built / name, package / name)
        _strip(package / name, machine)
    licenses = package / "licenses"
    licenses.mkdir(exist_ok=True)
    for owner in _STATIC_PACKAGES:
        _copy_license(owner, licenses)
    if REMOTE_LIBRARY in names:
        _bundle(package / REMOTE_LIBRARY, package / "libs", machine)


def copy_protobuf(package: pathlib.Path) -> None:
    """Copies the Python parts of protobuf into `package`, for environments without it."""
    shutil.copytree(
        _protobuf_folder(),
        package / "_vendor/google/protobuf",
        ignore=lambda _, names: [name for name in names if name.endswith((".so", "__pycache__"))],
    )


def platform_tag(package: pathlib.Path, machine: str) -> str:
    """Returns the platform tag: that of the newest glibc that a library of `package` needs."""
    newest = (2, 17)
    for library in sorted(package.rglob("*.so*")):
        versions = _run("readelf", "--version-info", "--wide", library)
        for glibc in re.findall(r"\bGLIBC_(\d+)\.(\d+)\b", versions):
            newest = max(newest, (int(glibc[0]), int(glibc[1])))
        for runtime in re.findall(r"\bGLIBCXX_(\d+)\.(\d+)\.(\d+)\b", versions):
            newest = max(newest, _glibc_of(tuple(map(int, runtime))))
    return f"manylinux_{newest[0]}_{newest[1]}_{machine}"


def _glibc_of(runtime: tuple[int, ...]) -> tuple[int, int]:
    if runtime < min(_GLIBC_OF_RUNTIME):
        return (2, 17)
    major, minor = platform.libc_ver()[1].split(".")
    return _GLIBC_OF_RUNTIME.get(runtime, (int(major), int(minor)))


def _bundle(library: pathlib.Path, folder: pathlib.Path, machine: str) -> None:
    """Copies what a library needs into `folder`, and lets it find it there."""
    require_tools({"patchelf": "patchelf", "ldd": "libc-bin"})
    folder.mkdir()
    sources = sorted(_needed(library))
    new_names = {source.name: _unique_name(source) for source in sources}
    for source in sources:
        copy = folder / new_names[source.name]
        shutil.copy2(source.resolve(), copy)
        _strip(copy, machine)
        _run("patchelf", "--set-soname", copy.name, copy)
        _link(copy, "$ORIGIN", new_names)
    _link(library, f"$ORIGIN/{folder.name}", new_names)
    _copy_licenses(sources, folder.parent / "licenses")


def _strip(file: pathlib.Path, machine: str) -> None:
    strip = "strip" if machine == platform.machine() else f"{machine}-linux-gnu-strip"
    require_tools({strip: "binutils"})
    _run(strip, "--strip-unneeded", file)


def _needed(file: pathlib.Path) -> set[pathlib.Path]:
    """Returns the libraries that a file needs, directly or not, and that are bundled."""
    found = set()
    for line in _run("ldd", file).splitlines():
        name, _, rest = line.strip().partition(" => ")
        if _SYSTEM_LIBRARIES.match(pathlib.Path(name.split()[0]).name):
            continue
        path = rest.split(" (")[0]
        if not path.startswith("/"):
            sys.exit(f"error: {file.name} needs {name}, which is not installed")
        found.add(pathlib.Path(path))
    return found


def _unique_name(library: pathlib.Path) -> str:
    stem, _, version = library.name.partition(".so")
    digest = hashlib.sha256(library.read_bytes()).hexdigest()[:8]
    return f"{stem}-{digest}.so{version}"


def _link(file: pathlib.Path, run_path: str, new_names: dict[str, str]) -> None:
    """Lets a file find the bundled libraries by their new names."""
    needed = _run("patchelf", "--print-needed", file).split()
    replacements = [
        argument
        for name in needed
        if name in new_names
        for argument in ("--replace-needed", name, new_names[name])
    ]
    # One change at a time: patchelf 0.14 writes wrong strings if it makes both at once.
    if replacements:
        _run("patchelf", *replacements, file)
    _run("patchelf", "--force-rpath", "--set-rpath", run_path, file)


def _copy_licenses(libraries: list[pathlib.Path], folder: pathlib.Path) -> None:
    """Copies the copyright file of each library's Debian package."""
    for library in libraries:
        for path in (library, library.resolve()):
            owner = subprocess.run(
                ["dpkg-query", "--search", path, str(path).removeprefix("/usr")],
                capture_output=True,
                text=True,
                check=False,
            ).stdout
            if owner:
                break
        else:
            sys.exit(f"error: no Debian package has {library}, so its license is unknown")
        _copy_license(owner.split(":")[0], folder)


def _copy_license(package: str, folder: pathlib.Path) -> None:
    """Copies the copyright file of a Debian package."""
    file = pathlib.Path(f"/usr/share/doc/{package}/copyright")
    if not file.exists():
        sys.exit(f"error: there is no {file}, so the license of {package} is unknown")
    shutil.copy2(file, folder / package)


def _protobuf_folder() -> str:
    """Returns the folder of the installed package google.protobuf."""
    try:
        spec = importlib.util.find_spec("google.protobuf")
    except ModuleNotFoundError:  # There is not even a package `google`.
        spec = None
    if spec is None or not spec.submodule_search_locations:
        sys.exit("error: the wheel needs protobuf; on Debian: apt install python3-protobuf")
    return spec.submodule_search_locations[0]


def _run(*command: str | pathlib.Path, cwd: pathlib.Path | None = None) -> str:
    run = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)
    if run.returncode != 0:
        output = (run.stdout + run.stderr)[-4000:]
        sys.exit(f"error: {' '.join(map(str, command))} failed:\n{output}")
    return run.stdout
