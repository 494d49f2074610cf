#!/usr/bin/env python3
"""Writes what a release contains of other projects: NOTICE and an SBOM in SPDX 2.3 (JSON).

The parts are the files in server/web/pages/vendor with the licenses beside them, and the Debian
packages that the built programs and libraries link, as this machine has them.

    deploy/release/make_notice.py build/release OUTPUT_FOLDER
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
from datetime import datetime, timezone
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote

_ROOT = Path(__file__).resolve().parents[2]
_VENDOR = _ROOT / "server/web/pages/vendor"


class Part(NamedTuple):
    name: str
    version: str
    license: str
    purl: str


def _run(*command: str) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def vendored_parts() -> list[Part]:
    """The table of server/web/pages/vendor/README.md."""
    row = re.compile(r"^\|.*\| `([^`]+)` ([0-9][^ ]*) \| ([^|(]+) \(", re.MULTILINE)
    return [
        Part(name, version, terms.replace("and", "AND"), f"pkg:npm/{quote(name)}@{version}")
        for name, version, terms in row.findall((_VENDOR / "README.md").read_text())
    ]


def linked_parts(build: Path) -> list[Part]:
    """The Debian packages of the shared libraries that the build's programs and libraries load."""
    programs = [build / "bin/procgen-server", *sorted((build / "lib").glob("*.so"))]
    files = set()
    for program in programs:
        files |= set(re.findall(r"=> (/\S+)", _run("ldd", str(program))))
    # dpkg knows a file by its path before or after the merge of /lib and /usr/lib.
    real = {str(Path(file).resolve()) for file in files if str(build) not in file}
    paths = real | {path.removeprefix("/usr") for path in real}
    owners = subprocess.run(["dpkg", "-S", *paths], capture_output=True, text=True).stdout
    packages = {line.split(":")[0] for line in owners.splitlines()}
    parts = []
    listed = _run("dpkg-query", "-W", "-f", "${Package} ${Version}\\n", *sorted(packages))
    for line in listed.splitlines():
        package, version = line.split()
        parts.append(Part(package, version, "NOASSERTION", f"pkg:deb/debian/{package}@{version}"))
    return parts


def notice(parts: list[Part]) -> str:
    texts = [
        "Procgen Server\nLicensed under the Apache License, version 2.0 (LICENSE).\n",
        "The web pages contain:\n",
    ]
    texts += [f"{part.name} {part.version} ({part.license})\n" for part in parts]
    for file in sorted(_VENDOR.glob("*.LICENSE")):
        texts.append(f"\n{'-' * 80}\n{file.stem}\n\n{file.read_text()}")
    return "".join(texts)


def spdx(version: str, vendored: list[Part], linked: list[Part]) -> dict[str, object]:
    def package(part: Part) -> dict[str, object]:
        return {
            "SPDXID": "SPDXRef-" + re.sub(r"[^A-Za-z0-9.]+", "-", part.name).strip("-"),
            "name": part.name,
            "versionInfo": part.version,
            "downloadLocation": "NOASSERTION",
            "licenseConcluded": part.license,
            "licenseDeclared": part.license,
            "copyrightText": "NOASSERTION",
            "filesAnalyzed": False,
            "externalRefs": [
                {
                    "referenceCategory": "PACKAGE-MANAGER",
                    "referenceType": "purl",
                    "referenceLocator": part.purl,
                }
            ],
        }

    purl = f"pkg:generic/procgen-server@{version}"
    own = package(Part("procgen-server", version, "Apache-2.0", purl))
    packages = [own, *map(package, vendored), *map(package, linked)]
    kinds = ["CONTAINS"] * len(vendored) + ["DYNAMIC_LINK"] * len(linked)
    relationships = [("SPDXRef-DOCUMENT", "DESCRIBES", own["SPDXID"])]
    relationships += [(own["SPDXID"], kind, p["SPDXID"]) for kind, p in zip(kinds, packages[1:])]
    return {
        "spdxVersion": "SPDX-2.3",
        "dataLicense": "CC0-1.0",
        "SPDXID": "SPDXRef-DOCUMENT",
        "name": f"procgen-server-{version}",
        "documentNamespace": f"https://spdx.org/spdxdocs/procgen-server-{version}",
        "creationInfo": {
            "created": datetime.now(timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ"),
            "creators": ["Tool: make_notice.py"],
        },
        "packages": packages,
        "relationships": [
            {"spdxElementId": one, "relationshipType": kind, "relatedSpdxElement": other}
            for one, kind, other in relationships
        ],
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build", type=Path, help="CMake's build folder")
    parser.add_argument("output", type=Path, help="folder for NOTICE and procgen-server.spdx.json")
    arguments = parser.parse_args()
    match = re.search(r"project\(\w+\s+VERSION ([0-9.]+)", (_ROOT / "CMakeLists.txt").read_text())
    assert match is not None
    vendored, linked = vendored_parts(), linked_parts(arguments.build.resolve())
    arguments.output.mkdir(parents=True, exist_ok=True)
    (arguments.output / "NOTICE").write_text(notice(vendored))
    sbom = json.dumps(spdx(match[1], vendored, linked), indent=1)
    (arguments.output / "procgen-server.spdx.json").write_text(sbom + "\n")


if __name__ == "__main__":
    main()
