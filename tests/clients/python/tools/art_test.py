"""The art of pools in this process: folders, the variable, and that of an installed package."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import server_binary

from procgen_client import Pool, ProcgenEnv, ProcgenGymEnv, ProcgenVectorEnv, ServerProcess, errors
from procgen_client.tools.art import ART_VARIABLE, art_dir

# Prints a hash of observations; argv[1] is the art.
_SHOW = """
import sys, zlib
from procgen_client import Pool
print(zlib.crc32(Pool("maze", 2, art=sys.argv[1] or None, rand_seed=3).observe().observations))
assert "procgen" not in sys.modules
"""


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
        env=os.environ | variables,
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


def test_art_changes_pixels_and_nothing_else(folder: str) -> None:
    own, given = (Pool("maze", 2, art=art, rand_seed=3) for art in (None, f"{folder}/"))
    env = ProcgenEnv(2, "maze", resource_root=folder, rand_seed=3)
    np.testing.assert_array_equal(given.observe().observations, env.reset()["rgb"])
    assert not np.array_equal(own.observe().observations, given.observe().observations)
    for t in range(40):
        one, other = own.step([t % 9, -1]), given.step([t % 9, -1])
        np.testing.assert_array_equal(one.level_seeds, other.level_seeds)
        np.testing.assert_array_equal(one.rewards, other.rewards)


def test_variable_names_the_default_art(folder: str) -> None:
    given = _run(_SHOW, folder).stdout
    assert given
    assert _run(_SHOW, "", **{ART_VARIABLE: folder}).stdout == given


def test_installed_art_is_found_without_importing_the_package(folder: str, tmp_path: Path) -> None:
    run = _run(_SHOW, "", **{ART_VARIABLE: "procgen"}, **_install(tmp_path, folder))
    assert run.stdout == _run(_SHOW, folder).stdout, run.stderr


def test_package_without_art_is_an_error(tmp_path: Path) -> None:
    run = _run(_SHOW, "procgen", **_install(tmp_path, None))
    assert f"procgen has no folder {tmp_path}/procgen/data/assets: pip install" in run.stderr


def test_missing_art_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(errors.NotFoundError, match=f"art is {tmp_path}/none, which is no folder"):
        ServerProcess(server_binary(), art=tmp_path / "none")
    with pytest.raises(errors.InvalidArgumentError, match="art is empty"):
        art_dir("")
    with pytest.raises(errors.NotFoundError, match=f"art folder '{tmp_path}'"):
        Pool("maze", 1, art=tmp_path)


@pytest.mark.parametrize("env_type", [ProcgenVectorEnv, ProcgenGymEnv])
def test_art_with_a_server_is_rejected(env_type: type, server: ServerProcess) -> None:
    for given in (server, server.address):
        with pytest.raises(errors.InvalidArgumentError, match="art is procgen, but the server at"):
            env_type("maze", server=given, art="procgen")
    with pytest.raises(errors.InvalidArgumentError, match="chooses its art by its flag --art_dir"):
        ProcgenEnv(2, "maze", server=server.address, art="procgen")


def test_missing_package_is_an_error() -> None:
    run = _run("from procgen_client.tools.art import art_dir; art_dir('procgen')")
    assert "the package procgen is not installed: pip install procgen==0.10.7, or" in run.stderr


def test_a_module_that_the_program_made_is_not_the_package() -> None:
    program = """
import sys, types
sys.modules["procgen"] = types.ModuleType("procgen")
from procgen_client.tools.art import art_dir, upstream_is_installed
assert not upstream_is_installed()
art_dir("procgen")
"""
    assert "the package procgen is not installed" in _run(program).stderr


def test_a_package_without_art_is_not_upstream(tmp_path: Path) -> None:
    variables = _install(tmp_path, None)
    program = "from procgen_client.tools.art import *; print(upstream_is_installed())"
    assert _run(program, **variables).stdout == "False\n"
    (tmp_path / "procgen/data/assets").mkdir()
    assert _run(program, **variables).stdout == "True\n"
