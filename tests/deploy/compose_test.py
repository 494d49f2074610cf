"""deploy/containers/compose.yaml matches the server's flags and the Dockerfile."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import server_flags
import yaml

_FOLDER = Path(__file__).resolve().parents[2] / "deploy" / "containers"
_COMPOSE = yaml.safe_load((_FOLDER / "compose.yaml").read_text())
_SERVERS = {n: s for n, s in _COMPOSE["services"].items() if s["image"] == "procgen-server"}
_SERVER = _COMPOSE["x-server"]
_DOCKERFILE = (_FOLDER / "Dockerfile").read_text()


def test_the_learner_lists_all_servers() -> None:
    learner = _COMPOSE["services"]["learner"]
    port = server_flags.values(_SERVER["command"])["address"].rpartition(":")[2]
    assert f"--server={','.join(f'{name}:{port}' for name in _SERVERS)}" in learner["command"]
    assert learner["depends_on"] == list(_SERVERS)
    assert learner["restart"] == "on-failure"  # It ends if no server is ready yet.


def test_learners_on_this_machine_reach_each_server_by_a_port() -> None:
    text = (_FOLDER / "compose.yaml").read_text()
    ports = [port.rpartition(":")[0] for service in _SERVERS.values() for port in service["ports"]]
    assert ",".join(ports) in text
    assert len(set(ports)) == len(_SERVERS) == 3


@pytest.mark.parametrize("name", _COMPOSE["services"])
def test_services_are_built_locally_and_restricted(name: str) -> None:
    service = _COMPOSE["services"][name]
    assert re.search(rf"^FROM .* AS {service['build']['target']}$", _DOCKERFILE, re.MULTILINE)
    root = _FOLDER.parents[1]
    assert (_FOLDER / service["build"]["context"]).resolve() == root
    assert (root / service["build"]["dockerfile"]).samefile(_FOLDER / "Dockerfile")
    assert service["read_only"] is True
    assert service["cap_drop"] == ["ALL"]
    assert set(service["networks"]) <= set(_COMPOSE["networks"])


def test_the_server_takes_all_flags() -> None:
    assert server_flags.complaint(_SERVER["command"]) == ""
