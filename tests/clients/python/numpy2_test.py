"""The native module works with NumPy 2, that of Debian 13, though built with an older pybind11."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from procgen_client import Client, ServerProcess

_ROOT = Path(__file__).resolve().parents[3]
_ARRAYS = ("rewards", "first", "level_seeds", "episode_returns", "episode_lengths", "observations")
_OPTIONS = {"distribution_mode": "easy", "rand_seed": 0}
_PROGRAM = f"""
import json, sys
import numpy as np
from procgen_client import Client
from procgen_client._transport import is_native
assert is_native() and np.__version__ >= "2", np.__version__
with Client(sys.argv[1]) as client, client.create_pool("bigfish", 8, **{_OPTIONS}) as pool:
    for t in range(50):
        batch = pool.step(np.arange(t, t + 8) % 15)
    print(json.dumps({{name: getattr(batch, name).tolist() for name in {_ARRAYS}}}))
"""


@pytest.fixture(scope="module")
def newer_root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A root file system of Debian 13 with NumPy, and the package with this build's module."""
    if os.geteuid() != 0:
        pytest.skip("chroot needs root")
    root = tmp_path_factory.mktemp("newer") / "root"
    subprocess.run(
        ["mmdebstrap", "--variant=minbase",
         "--include=python3-dev,python3-numpy,python3-protobuf", "trixie", root],
        check=True,
    )  # fmt: skip
    (headers,) = (root / "usr/include").glob("python3.*")
    package = root / "opt/procgen_client"
    shutil.copytree(
        _ROOT / "clients/python/procgen_client", package, ignore=shutil.ignore_patterns("*.so")
    )
    version = headers.name.removeprefix("python").replace(".", "")
    module = package / f"_native.cpython-{version}-x86_64-linux-gnu.so"
    _build_module(headers, module)
    libraries = root / "opt/libraries"
    libraries.mkdir()
    for path in re.findall(r"=> (/\S+)", _output("ldd", module)):
        if not re.search(r"/(ld-linux|lib(c|m|gcc_s|stdc\+\+))[.-]", path):
            shutil.copy2(path, libraries)
    return root


def _build_module(headers: Path, module: Path) -> None:
    """Builds the module as this build does, for the Python that has these headers."""
    built = Path(os.environ["PROCGEN_CLIENT_NATIVE"])
    build = built.parents[1]
    (target,) = built.glob("_native.*.so")
    commands = _output("ninja", "-C", build, "-t", "commands", target.relative_to(build))
    # Debian's pyconfig.h includes one from a folder of the architecture.
    system = module.parent / "headers"
    (system / "x86_64-linux-gnu").mkdir(parents=True)
    (system / "x86_64-linux-gnu" / headers.name).symlink_to(
        headers.parent / "x86_64-linux-gnu" / headers.name
    )
    objects: dict[str, str] = {}
    for line in commands.splitlines():
        if " -c " not in line or "clients/python/native/" not in line:
            continue
        command = shlex.split(line)
        output = command.index("-o") + 1
        objects[command[output]] = str(module.parent / Path(command[output]).name)
        command[output] = objects[command[output]]
        first = next(i for i, word in enumerate(command) if word.startswith("-"))
        command[first:first] = ["-isystem", str(headers), "-isystem", str(system)]
        subprocess.run(command, cwd=build, check=True)
    link = commands.splitlines()[-1].removeprefix(": && ").split(" && ")[0]
    command = [objects.get(word, word) for word in shlex.split(link)]
    command[command.index("-o") + 1] = str(module)
    subprocess.run(command, cwd=build, check=True)


def _output(*command: str | Path) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def test_arrays_equal_those_of_this_numpy(
    newer_root: Path, server: ServerProcess, client: Client
) -> None:
    with client.create_pool("bigfish", 8, **_OPTIONS) as pool:
        for t in range(50):
            batch = pool.step(np.arange(t, t + 8) % 15)
    (newer_root / "opt/program.py").write_text(_PROGRAM)
    output = _output(
        *("chroot", newer_root, "env", "LD_LIBRARY_PATH=/opt/libraries"),
        *("python3", "/opt/program.py", server.address),
    )
    arrays = json.loads(output)
    for name in _ARRAYS:
        np.testing.assert_array_equal(arrays[name], getattr(batch, name), err_msg=name)
    assert len(set(arrays["level_seeds"])) > 1
