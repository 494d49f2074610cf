"""Versions agree, commands of the workflows exist, the SBOM names what is linked."""

from __future__ import annotations

import json
import os
import re
import subprocess
from pathlib import Path

import yaml

_ROOT = Path(__file__).resolve().parents[2]


def _first(pattern: str, path: str) -> str:
    match = re.search(pattern, (_ROOT / path).read_text(), re.MULTILINE)
    assert match is not None, path
    return match[1]


def test_all_places_have_one_version() -> None:
    package = "clients/python/procgen_package/pyproject.toml"
    versions = {
        _first(r"project\(\w+\s+VERSION ([0-9.]+)", "CMakeLists.txt"),
        _first(r'^version = "([0-9.]+)"', "clients/python/pyproject.toml"),
        _first(r'^__version__ = "([0-9.]+)"', "clients/python/procgen_client/__init__.py"),
        _first(r'^version = "([0-9.]+)"', package),
        _first(r'procgen-server==([0-9.]+)"', package),
        _first(r"^version: ([0-9.]+)", "CITATION.cff"),
        _first(r"^## \[([0-9.]+)\]", "CHANGELOG.md"),
    }
    assert len(versions) == 1, versions


def test_commands_of_the_workflows_exist() -> None:
    commands = []
    for file in sorted((_ROOT / ".github/workflows").glob("*.yml")):
        for job in yaml.safe_load(file.read_text())["jobs"].values():
            commands += [step["run"] for step in job["steps"] if "run" in step]
    script = r"(?:^|\s)((?:\.ci|deploy|docs|clients|tests)/\S+)"
    scripts = set(re.findall(script, "\n".join(commands)))
    assert {".ci/run", "clients/python/build_wheel.sh", "docs/build.sh"} <= scripts
    for each in scripts:
        assert (_ROOT / each).exists(), each
    flags = re.findall(r"deploy/install-dependencies.sh((?: --\S+)+)", "\n".join(commands))
    for flag in {flag for group in flags for flag in group.split()}:
        listed = subprocess.run(
            [_ROOT / "deploy/install-dependencies.sh", flag, "--list"], capture_output=True
        )
        assert listed.returncode == 0, flag


def test_notice_and_sbom_have_the_parts_of_a_build(tmp_path: Path) -> None:
    build = Path(os.environ["PROCGEN_SERVER_BINARY"]).parents[1]
    script = _ROOT / "deploy/release/make_notice.py"
    subprocess.run([script, build, tmp_path], check=True)
    notice = (tmp_path / "NOTICE").read_text()
    assert "uplot" in notice
    assert "Permission is hereby granted" in notice
    sbom = json.loads((tmp_path / "procgen-server.spdx.json").read_text())
    names = [package["name"] for package in sbom["packages"]]
    assert {"@bufbuild/protobuf", "uplot", "libgrpc++1.51", "libc6"} <= set(names)
    assert len({package["SPDXID"] for package in sbom["packages"]}) == len(names)
    known = {package["SPDXID"] for package in sbom["packages"]} | {"SPDXRef-DOCUMENT"}
    for relation in sbom["relationships"]:
        assert {relation["spdxElementId"], relation["relatedSpdxElement"]} <= known
