"""Presets need the packages that they say, and a missing package is named."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

_ROOT = Path(__file__).resolve().parents[2]


def _configure(
    tree: Path, *without: str, preset: str = "release"
) -> subprocess.CompletedProcess[str]:
    """Configures a preset as if these packages were not installed.

    Sources are compiled one by one, so that the commands name them.
    """
    flags = [f"-DCMAKE_DISABLE_FIND_PACKAGE_{package}=ON" for package in without]
    flags += ["-DPROCGEN_UNITY=OFF", "-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON"]
    return subprocess.run(
        ["cmake", "--preset", preset, "-B", tree, *flags],
        cwd=_ROOT,
        capture_output=True,
        text=True,
        check=False,
    )


def test_release_needs_no_package_of_the_tests(tmp_path: Path) -> None:
    result = _configure(tmp_path, "GTest", "benchmark")
    assert result.returncode == 0, result.stderr
    compiled = json.loads((tmp_path / "compile_commands.json").read_text())
    tests = str(_ROOT / "tests")
    assert compiled
    assert not [command["file"] for command in compiled if command["file"].startswith(tests)]
    assert not [command for command in compiled if "-Werror" in command["command"]]


def test_a_missing_package_is_named_with_the_command_that_installs_it(tmp_path: Path) -> None:
    result = _configure(tmp_path, "spdlog")
    assert result.returncode != 0
    message = " ".join(result.stderr.split())
    assert (
        "spdlog was not found. This command installs it on Debian: deploy/install-dependencies.sh"
        in message
    )


def test_the_library_needs_no_grpc(tmp_path: Path) -> None:
    result = _configure(
        tmp_path,
        *("gRPC", "Protobuf", "OpenSSL", "spdlog", "prometheus-cpp", "CycloneDDS", "PNG"),
        *("PkgConfig", "Boost", "GTest", "benchmark"),
        preset="library",
    )
    assert result.returncode == 0, result.stderr
    compiled = json.loads((tmp_path / "compile_commands.json").read_text())
    folders = {Path(each["file"]).relative_to(_ROOT).parts[0] for each in compiled}
    assert folders == {"clients", "envcore"}
