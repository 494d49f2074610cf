"""The art of local servers: folders, the variable, and that of an installed package."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import server_binary

from procgen_client import ProcgenEnv, ProcgenGymEnv, ProcgenVectorEnv, ServerProcess, errors
from procgen_client.tools.art import art_dir
from procgen_client.tools.local_server import ART_VARIABLE

_SHOW = """
import sys
import numpy as np
from procgen_client import ProcgenEnv, ProcgenVectorEnv
options = {"rand_seed": 3}
"""
# argv[1] is a folder of art; the variable has none.
_OF_ONE_PROGRAM = (
    _SHOW
    + """
built_in = ProcgenEnv(2, "maze", **options)
others = [
    ProcgenEnv(2, "maze", art=sys.argv[1] + "/", **options),
    ProcgenEnv(2, "maze", resource_root=sys.argv[1], **options),
]
vector = ProcgenVectorEnv("maze", 2, art=sys.argv[1], **options)
observations, _ = vector.reset()
for env in others:
    assert env.env.pool._client.address == vector.pool._client.address
    assert not np.array_equal(built_in.reset()["rgb"], env.reset()["rgb"])
    assert np.array_equal(observations, env.reset()["rgb"])
assert built_in.env.pool._client.address != vector.pool._client.address
"""
)
_OF_THE_VARIABLE = (
    _SHOW
    + """
assert ProcgenEnv(2, "maze").env.pool._client.catalog().art == "folder"
assert "procgen" not in sys.modules
"""
)


@pytest.fixture
def folder() -> str:
    """A folder of art, drawn by the build."""
    painted = os.environ.get("PROCGEN_PAINTED_ART_DIR")
    if painted is None:
        pytest.skip("PROCGEN_PAINTED_ART_DIR is not set; CTest sets it")
    return os.path.dirname(painted)


def _run(program: str, *arguments: str, **variables: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", program, *arguments],
        env=os.environ | {"PROCGEN_SERVER_BINARY": str(server_binary())} | variables,
        capture_output=True,
        text=True,
        check=False,
    )


def _install(folder: Path, art: str | None) -> dict[str, str]:
    """Makes a package `procgen` that cannot be imported; returns the variable with its path."""
    (folder / "procgen/data").mkdir(parents=True)
    (folder / "procgen/__init__.py").write_text("raise ImportError('the package was imported')\n")
    if art is not None:
        (folder / "procgen/data/assets").symlink_to(art)
    return {"PYTHONPATH": f"{folder}:{os.environ['PYTHONPATH']}"}


def test_each_art_dir_has_its_own_server(folder: str) -> None:
    run = _run(_OF_ONE_PROGRAM, folder)
    assert run.returncode == 0, run.stderr


def test_variable_names_the_default_art(folder: str) -> None:
    run = _run(_OF_THE_VARIABLE, **{ART_VARIABLE: folder})
    assert run.returncode == 0, run.stderr


def test_installed_art_is_found_without_importing_the_package(folder: str, tmp_path: Path) -> None:
    run = _run(_OF_THE_VARIABLE, **{ART_VARIABLE: "procgen"}, **_install(tmp_path, folder))
    assert run.returncode == 0, run.stderr


def test_package_without_art_is_an_error(tmp_path: Path) -> None:
    run = _run(_OF_THE_VARIABLE, **{ART_VARIABLE: "procgen"}, **_install(tmp_path, None))
    assert f"procgen has no folder {tmp_path}/procgen/data/assets: pip install" in run.stderr


def test_missing_art_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(errors.NotFoundError, match=f"art is {tmp_path}/none, which is no folder"):
        ServerProcess(server_binary(), art=tmp_path / "none")
    with pytest.raises(errors.InvalidArgumentError, match="art is empty"):
        art_dir("")
    run = _run(_OF_THE_VARIABLE, **{ART_VARIABLE: str(tmp_path)})
    assert f"art folder '{tmp_path}'" in run.stderr, "a folder without pictures"


@pytest.mark.parametrize("env_type", [ProcgenVectorEnv, ProcgenGymEnv])
def test_art_of_another_server_is_rejected(env_type: type, server: ServerProcess) -> None:
    for given in (server, server.address):
        with pytest.raises(errors.InvalidArgumentError, match="art is procgen, but the server at"):
            env_type("maze", server=given, art="procgen")
    with pytest.raises(errors.InvalidArgumentError, match="chooses its art by its flag --art_dir"):
        ProcgenEnv(2, "maze", server=server.address, art="procgen")


def test_missing_package_is_an_error() -> None:
    run = _run("from procgen_client.tools.art import art_dir; art_dir('procgen')")
    assert "the package procgen is not installed: pip install procgen, or give" in run.stderr
