"""deploy/containers/compose.yaml matches the server's flags and the Dockerfile."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
import server_flags
import yaml

_FOLDER = Path(__file__).resolve().parents[2] / "deploy" / "containers"
_COMPOSE = yaml.safe_load((_FOLDER / "compose.yaml").read_text())
_SERVERS = {n: s for n, s in _COMPOSE["services"].items() if s["image"] == "procgen-server"}
_DOCKERFILE = (_FOLDER / "Dockerfile").read_text()


def flags(service: dict[str, Any]) -> dict[str, str]:
    return server_flags.values(service["command"])


def test_there_are_three_nodes_and_a_fleet_server_in_one_cluster() -> None:
    fleets = [name for name, service in _SERVERS.items() if "fleet" in flags(service)]
    assert fleets == ["fleet"]
    assert len(_SERVERS) == 4
    assert {flags(service)["cluster"] for service in _SERVERS.values()} == {"procgen"}


@pytest.mark.parametrize("name", _SERVERS)
def test_servers_advertise_their_addresses(name: str) -> None:
    port = flags(_SERVERS[name])["address"].rpartition(":")[2]
    assert flags(_SERVERS[name])["advertised_address"] == f"{name}:{port}"
    assert flags(_SERVERS[name])["node_id"] == name


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


def test_the_learner_waits_for_the_fleet_server() -> None:
    learner = _COMPOSE["services"]["learner"]
    assert "--server=fleet:50051" in learner["command"]
    assert learner["depends_on"]["fleet"]["condition"] == "service_healthy"
    assert "healthcheck" in _COMPOSE["services"]["fleet"]


def test_the_fleet_servers_state_is_on_a_volume() -> None:
    (volume,) = _SERVERS["fleet"]["volumes"]
    name, folder = volume.split(":")
    assert name in _COMPOSE["volumes"]
    assert folder == flags(_SERVERS["fleet"])["state_dir"]


@pytest.mark.parametrize("name", _SERVERS)
def test_the_server_takes_all_flags(name: str) -> None:
    assert server_flags.complaint(_SERVERS[name]["command"]) == ""
