"""The Debian package: installed, run and purged, on a temporary file system."""

from __future__ import annotations

import configparser
import os
import re
import shlex
import shutil
import subprocess
import urllib.request
from pathlib import Path

import pytest
from throwaway_root import NotPermittedError, ThrowawayRoot

from procgen_client import Client

_PACKAGES = Path(os.environ["PROCGEN_PACKAGES"])
_UNIT = Path("usr/lib/systemd/system/procgen-server.service")
_FLAGS = Path("etc/procgen-server/server.flags")
_EXPOSURE_MAX = 20  # Of 100, as reported by systemd-analyze security.


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> ThrowawayRoot:
    """A file system with the packages in /tmp, not installed."""
    try:
        made = ThrowawayRoot(tmp_path_factory.mktemp("throwaway"))
    except NotPermittedError as error:
        pytest.skip(str(error))
    for name in ("procgen-server", "procgen-server-dev"):
        (package,) = _PACKAGES.glob(f"{name}_*.deb")
        shutil.copy(package, made.path / "tmp" / f"{name}.deb")
        made.run("dpkg", "--purge", name)
    return made


def install(root: ThrowawayRoot) -> None:
    result = root.run("dpkg", "--install", "/tmp/procgen-server.deb")
    assert result.returncode == 0, result.stderr


@pytest.fixture(scope="module")
def installed(root: ThrowawayRoot) -> ThrowawayRoot:
    """A file system with the server's package installed."""
    install(root)
    return root


def unit(root: ThrowawayRoot) -> configparser.SectionProxy:
    parser = configparser.ConfigParser(strict=False, interpolation=None)
    parser.optionxform = str
    parser.read(root.path / _UNIT)
    return parser["Service"]


def service(root: ThrowawayRoot) -> subprocess.Popen[str]:
    """Runs the unit's command as the unit's user."""
    section = unit(root)
    return root.start(*shlex.split(section["ExecStart"]), user=section["User"])


def await_address(process: subprocess.Popen[str]) -> str:
    lines = []
    for line in process.stdout:
        lines.append(line)
        if match := re.match(r"listening on (\S+)", line):
            return match.group(1)
    raise AssertionError("".join(lines))


def seconds(text: str) -> float:
    return float(re.fullmatch(r"(\d+)s", text).group(1))


def test_the_installed_service_serves_and_stops(installed: ThrowawayRoot) -> None:
    process = service(installed)
    try:
        with Client(await_address(process)) as client, client.create_pool("coinrun", 2) as pool:
            assert pool.step([7, 7]).observations.shape == (2, 64, 64, 3)
        with urllib.request.urlopen("http://127.0.0.1:9464/metrics") as page:
            assert b'procgen_steps_total{game="coinrun"' in page.read()
    finally:
        process.terminate()
    assert process.wait(timeout=seconds(unit(installed)["TimeoutStopSec"])) == 0


@pytest.mark.parametrize("command", ["procgen-server", "procgen-make-credentials"])
def test_manual_pages_render_without_warnings(installed: ThrowawayRoot, command: str) -> None:
    page = f"/usr/share/man/man1/{command}.1.gz"
    rendered = installed.run("env", "LC_ALL=C.UTF-8", "man", "--warnings", "--local-file", page)
    assert (rendered.returncode, rendered.stderr) == (0, "")
    assert f"SYNOPSIS\n       {command} " in rendered.stdout


def test_bash_completes_all_flags_of_help(installed: ThrowawayRoot) -> None:
    text = installed.run("procgen-server", "--help").stdout
    flags = set(re.findall(r"^ +(--\w+) \(", text, re.MULTILINE))
    assert len(flags) > 20
    script = (
        "source /usr/share/bash-completion/completions/procgen-server; compopt() { :; };"
        '_procgen_server procgen-server "$0"; echo "${COMPREPLY[@]}"'
    )
    offered = installed.run("bash", "-c", script, "--").stdout.split()
    assert flags | {"--flagfile", "--help", "--version"} == {each.rstrip("=") for each in offered}
    assert installed.run("bash", "-c", script, "--tls_k").stdout == "--tls_key=\n"
    page = installed.run("env", "LC_ALL=C.UTF-8", "man", "procgen-server").stdout
    assert flags <= set(re.findall(r"^ +(--\w+)=VALUE", page, re.MULTILINE))


def test_the_service_has_its_own_user(installed: ThrowawayRoot) -> None:
    entry = installed.run("getent", "passwd", unit(installed)["User"]).stdout.strip().split(":")
    assert int(entry[2]) not in (0, 65534)
    assert entry[6] == "/usr/sbin/nologin"


def test_drain_ends_before_systemds_timeout(installed: ThrowawayRoot) -> None:
    # A second for running requests, and two until the metrics page has ended.
    assert seconds(unit(installed)["TimeoutStopSec"]) >= 10


def test_the_unit_is_valid_and_restricted(installed: ThrowawayRoot) -> None:
    if shutil.which("systemd-analyze") is None:
        pytest.skip("there is no systemd-analyze")
    verified = installed.run("systemd-analyze", "verify", f"/{_UNIT}")
    assert (verified.returncode, verified.stderr) == (0, "")
    exposure = installed.run(
        *("systemd-analyze", "security", "--offline=true"),
        *(f"--threshold={_EXPOSURE_MAX}", f"/{_UNIT}"),
    )
    assert exposure.returncode == 0, exposure.stdout


def test_changed_flags_survive_upgrade_and_removal(installed: ThrowawayRoot) -> None:
    flags = installed.path / _FLAGS
    flags.write_text("--address=127.0.0.1:50060\n")
    install(installed)
    assert flags.read_text() == "--address=127.0.0.1:50060\n"
    assert installed.run("dpkg", "--remove", "procgen-server").returncode == 0
    assert flags.read_text() == "--address=127.0.0.1:50060\n"
    assert not (installed.path / "usr/bin/procgen-server").exists()


def test_a_purge_leaves_nothing(installed: ThrowawayRoot) -> None:
    install(installed)
    result = installed.run("dpkg", "--purge", "procgen-server")
    assert (result.returncode, result.stderr) == (0, "")
    folders = ("etc", "usr/*", "var/lib")
    assert [path for f in folders for path in installed.path.glob(f"{f}/procgen*")] == []


def test_the_development_package_has_the_protos_and_the_library(root: ThrowawayRoot) -> None:
    result = root.run("dpkg", "--install", "/tmp/procgen-server-dev.deb")
    assert result.returncode == 0, result.stderr
    protos = "/usr/share/procgen-server/proto"
    names = [path.name for path in (root.path / protos[1:] / "procgen/v1").iterdir()]
    generated = root.run(
        "protoc", f"--proto_path={protos}", "--python_out=/tmp", *(f"procgen/v1/{n}" for n in names)
    )
    assert (generated.returncode, generated.stderr) == (0, "")
    loaded = root.run("ldd", "/usr/lib/procgen/libenv.so")
    assert loaded.returncode == 0
    assert "not found" not in loaded.stdout
