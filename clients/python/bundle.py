"""Bundles native parts into a wheel: programs, the native module, and the libraries they need.

Libraries of the C library and of GCC's runtime stay the system's (glibc 2.36 or newer). All others
are copied under names of their own, so that they do not collide with other copies in a process.
"""

from __future__ import annotations

import hashlib
import importlib.util
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig

PROGRAMS = ("procgen-server", "procgen-top")

_SYSTEM_LIBRARIES = re.compile(
    r"(linux-vdso|ld-linux-x86-64|libc|libm|libdl|librt|libpthread|libstdc\+\+|libgcc_s)\.so"
)
_TOOLS = {
    "cmake": "cmake",
    "ninja": "ninja-build",
    "c++": "g++",
    "patchelf": "patchelf",
    "strip": "binutils",
    "ldd": "libc-bin",
}


def require_tools(package_of: dict[str, str], hint: str = "") -> None:
    """Exits with a message if tools are missing. `package_of`: Debian package of each tool."""
    missing = [tool for tool in package_of if shutil.which(tool) is None]
    if missing:
        packages = " ".join(sorted({package_of[tool] for tool in missing}))
        sys.exit(
            f"error: building the wheel needs {', '.join(missing)}; on Debian: apt install "
            f"{packages}, or deploy/install-dependencies.sh.{hint}"
        )


def build(checkout: pathlib.Path, package: pathlib.Path) -> None:
    """Builds the native parts of `checkout` and puts them into the folder `package`."""
    require_tools(_TOOLS, " PROCGEN_WHEEL=pure builds a client without native parts.")
    protobuf = _protobuf_folder()
    tree = checkout / "build/release"
    module_name = f"_native{sysconfig.get_config_var('EXT_SUFFIX')}"
    _run("cmake", "--preset", "release", f"-DPROCGEN_SYSTEM_PYTHON={sys.executable}", cwd=checkout)
    _run("cmake", "--build", tree, "--target", *PROGRAMS, "procgen-python-client", cwd=checkout)

    libraries = package / "libs"
    programs = package / "bin"
    for folder in (libraries, programs):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
    module = package / module_name
    shutil.copy2(tree / "python/procgen_client" / module_name, module)
    for program in PROGRAMS:
        shutil.copy2(tree / "bin" / program, programs / program)

    sources = sorted(set().union(*(_needed(file) for file in (module, *programs.iterdir()))))
    new_names = {source.name: _unique_name(source) for source in sources}
    for source in sources:
        copy = libraries / new_names[source.name]
        shutil.copy2(source.resolve(), copy)
        _run("patchelf", "--set-soname", copy.name, copy)
    for file, run_path in [
        (module, "$ORIGIN/libs"),
        *((program, "$ORIGIN/../libs") for program in programs.iterdir()),
        *((library, "$ORIGIN") for library in libraries.iterdir()),
    ]:
        _run("strip", "--strip-unneeded", file)
        _link(file, run_path, new_names)
    _copy_licenses(sources, package / "licenses")
    # The Python parts of protobuf, for environments without it.
    vendored = package / "_vendor"
    shutil.rmtree(vendored, ignore_errors=True)
    shutil.copytree(
        protobuf,
        vendored / "google/protobuf",
        ignore=lambda _, names: [name for name in names if name.endswith((".so", "__pycache__"))],
    )


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
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
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
        package = owner.split(":")[0]
        shutil.copy2(f"/usr/share/doc/{package}/copyright", folder / package)


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
