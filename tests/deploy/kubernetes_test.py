"""The overlays of deploy/kubernetes: the rendered objects are consistent.

Uses no cluster: kubectl renders the overlays. The tests compare them with the server's flags and
health services.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import grpc
import pytest
import server_flags
import yaml

from procgen_client import ServerProcess

_FOLDER = Path(__file__).resolve().parents[2] / "deploy" / "kubernetes"
_OVERLAYS = sorted(path.name for path in (_FOLDER / "overlays").iterdir())


class Overlay:
    """The rendered objects of an overlay."""

    def __init__(self, name: str) -> None:
        result = subprocess.run(
            ["kubectl", "kustomize", _FOLDER / "overlays" / name],
            capture_output=True,
            text=True,
            check=False,
        )
        assert result.returncode == 0, result.stderr
        self.name = name
        self.objects: list[dict[str, Any]] = list(yaml.safe_load_all(result.stdout))

    def of_kind(self, kind: str) -> list[dict[str, Any]]:
        """All objects of a kind."""
        return [each for each in self.objects if each["kind"] == kind]

    def named(self, kind: str, name: str) -> dict[str, Any]:
        """The object of a kind with this name."""
        (found,) = [each for each in self.of_kind(kind) if each["metadata"]["name"] == name]
        return found

    def workloads(self) -> list[dict[str, Any]]:
        """Objects that create pods."""
        return self.of_kind("StatefulSet") + self.of_kind("Deployment")

    def matching(self, labels: dict[str, str]) -> list[dict[str, Any]]:
        """The workloads whose pods have all of `labels`."""
        return [each for each in self.workloads() if labels.items() <= pod_labels(each).items()]

    def flags(self, server: dict[str, Any]) -> list[str]:
        """The server's flags in a StatefulSet."""
        files = {}
        for volume in pod(server)["volumes"]:
            if "configMap" in volume:
                data = self.named("ConfigMap", volume["configMap"]["name"])["data"]
                folder = mount_paths(server)[volume["name"]]
                files |= {f"{folder}/{file}": text for file, text in data.items()}
        return server_flags.expand(container(server)["args"], files)


def pod(workload: dict[str, Any]) -> dict[str, Any]:
    return workload["spec"]["template"]["spec"]


def pod_labels(workload: dict[str, Any]) -> dict[str, str]:
    return workload["spec"]["template"]["metadata"]["labels"]


def container(workload: dict[str, Any]) -> dict[str, Any]:
    (only,) = pod(workload)["containers"]
    return only


def ports(workload: dict[str, Any]) -> dict[str, int]:
    return {each["name"]: each["containerPort"] for each in container(workload).get("ports", [])}


def mount_paths(workload: dict[str, Any]) -> dict[str, str]:
    return {each["name"]: each["mountPath"] for each in container(workload)["volumeMounts"]}


def probes(workload: dict[str, Any]) -> list[dict[str, Any]]:
    kinds = ("startupProbe", "readinessProbe", "livenessProbe")
    return [container(workload)[kind] for kind in kinds]


def port_of(address: str) -> int:
    return int(address.rpartition(":")[2])


@pytest.fixture(scope="module", params=_OVERLAYS)
def overlay(request: pytest.FixtureRequest) -> Overlay:
    if shutil.which("kubectl") is None:
        pytest.skip("there is no kubectl")
    return Overlay(request.param)


@pytest.fixture(scope="module")
def health() -> Iterator[grpc.UnaryUnaryMultiCallable]:
    """Returns a running server's response to a health check, as bytes: 0801 is SERVING."""
    with ServerProcess() as server, grpc.insecure_channel(server.address) as channel:
        yield channel.unary_unary("/grpc.health.v1.Health/Check")


def test_selectors_match_pods(overlay: Overlay) -> None:
    for workload in overlay.workloads():
        assert workload in overlay.matching(workload["spec"]["selector"]["matchLabels"])
    for service in overlay.of_kind("Service"):
        assert overlay.matching(service["spec"]["selector"])
    for budget in overlay.of_kind("PodDisruptionBudget"):
        assert len(overlay.matching(budget["spec"]["selector"]["matchLabels"])) == 1
    for policy in overlay.of_kind("NetworkPolicy"):
        assert overlay.matching(policy["spec"]["podSelector"]["matchLabels"])
    for workload in overlay.workloads():
        terms = pod(workload).get("affinity", {}).get("podAntiAffinity", {})
        for term in terms.get("preferredDuringSchedulingIgnoredDuringExecution", []):
            labels = term["podAffinityTerm"]["labelSelector"]["matchLabels"]
            assert overlay.matching(labels) == [workload]
        for constraint in pod(workload).get("topologySpreadConstraints", []):
            assert overlay.matching(constraint["labelSelector"]["matchLabels"]) == [workload]


def test_learners_list_all_servers(overlay: Overlay) -> None:
    (server,) = overlay.of_kind("StatefulSet")
    service = overlay.named("Service", server["spec"]["serviceName"])
    assert service["spec"]["clusterIP"] == "None"
    assert server in overlay.matching(service["spec"]["selector"])
    names = [f"{server['metadata']['name']}-{i}" for i in range(server["spec"]["replicas"])]
    hosts = [f"{name}.{service['metadata']['name']}" for name in names]
    (port,) = service["spec"]["ports"]
    assert port["targetPort"] in ports(server)
    addresses = ",".join(f"{host}:{port['port']}" for host in hosts)
    readme = (_FOLDER / "README.md").read_text()
    assert f'server="{addresses}"' in readme
    assert f" {','.join(hosts)} " in readme  # The names that a certificate is valid for.
    for learner in overlay.of_kind("Deployment"):
        assert f"--server={addresses}" in container(learner)["args"]


def test_ports_agree_with_flags(overlay: Overlay) -> None:
    for server in overlay.of_kind("StatefulSet"):
        flags = server_flags.values(overlay.flags(server))
        assert ports(server)["grpc"] == port_of(flags["address"])
        assert ports(server)["metrics"] == port_of(flags["metrics_address"])
        annotations = server["spec"]["template"]["metadata"]["annotations"]
        assert int(annotations["prometheus.io/port"]) == ports(server)["metrics"]
        for probe in probes(server):
            (how,) = [probe[kind] for kind in ("grpc", "tcpSocket", "httpGet") if kind in probe]
            expected = "metrics" if "httpGet" in probe else "grpc"
            assert how["port"] in (expected, ports(server)[expected])


def test_the_network_policy_admits_learners_and_prometheus(overlay: Overlay) -> None:
    policy = overlay.named("NetworkPolicy", "procgen")["spec"]
    (server,) = overlay.matching(policy["podSelector"]["matchLabels"])
    learners, prometheus = policy["ingress"]
    assert learners["ports"] == [{"port": ports(server)["grpc"]}]
    assert prometheus["ports"] == [{"port": ports(server)["metrics"]}]
    (peer,) = learners["from"]
    assert overlay.matching(peer["podSelector"]["matchLabels"]) == overlay.of_kind("Deployment")


def test_grpc_probes_are_answered(
    overlay: Overlay, health: grpc.UnaryUnaryMultiCallable
) -> None:
    for server in overlay.of_kind("StatefulSet"):
        secured = "tls_certificate" in server_flags.values(overlay.flags(server))
        for probe in probes(server):
            assert ("grpc" in probe) != secured  # gRPC probes do not use TLS.
            if "grpc" in probe:
                name = probe["grpc"].get("service", "").encode()
                assert health(b"\x0a" + bytes([len(name)]) + name) == b"\x08\x01"


def test_mounted_volumes_exist(overlay: Overlay) -> None:
    readme = (_FOLDER / "README.md").read_text()
    for server in overlay.of_kind("StatefulSet"):
        volumes = {each["name"]: each for each in pod(server)["volumes"]}
        assert mount_paths(server).keys() == volumes.keys()
        for volume in volumes.values():
            if "configMap" in volume:
                assert overlay.named("ConfigMap", volume["configMap"]["name"])
            else:  # Created by hand, as the guide describes.
                name = volume["secret"]["secretName"]
                assert re.search(rf"kubectl .*create secret \S+ {name} ", readme), name
        flags = server_flags.values(overlay.flags(server))
        assert all(path_is_mounted(server, path) for path in flags.values() if path[:1] == "/")


def path_is_mounted(server: dict[str, Any], path: str) -> bool:
    """Whether a volume contains `path`; for a secret, whether the guide adds it."""
    readme = (_FOLDER / "README.md").read_text()
    volumes = {each["name"]: each for each in pod(server)["volumes"]}
    for name, folder in mount_paths(server).items():
        if Path(path).parent == Path(folder):
            secret = volumes[name]["secret"]["secretName"]
            return re.search(rf"{secret} .*--from-file={Path(path).name}[=\s]", readme) is not None
    return False


def test_workers_and_timeouts_fit_the_pods_resources(overlay: Overlay) -> None:
    for server in overlay.of_kind("StatefulSet"):
        flags = server_flags.values(overlay.flags(server))
        if "workers" in flags:
            assert flags["workers"] == container(server)["resources"]["requests"]["cpu"]
        # A second for running requests, and two until the metrics page has ended.
        assert pod(server)["terminationGracePeriodSeconds"] >= 10


def test_pods_have_minimal_privileges(overlay: Overlay) -> None:
    for workload in overlay.workloads():
        assert pod(workload)["automountServiceAccountToken"] is False
        assert pod(workload)["securityContext"]["runAsNonRoot"] is True
        assert pod(workload)["securityContext"]["runAsUser"] == 10001
        assert container(workload)["securityContext"] == {
            "allowPrivilegeEscalation": False,
            "readOnlyRootFilesystem": True,
            "capabilities": {"drop": ["ALL"]},
        }
        assert {"requests", "limits"} <= container(workload)["resources"].keys()


def test_production_requires_authentication() -> None:
    if shutil.which("kubectl") is None:
        pytest.skip("there is no kubectl")
    production = Overlay("production")
    for server in production.of_kind("StatefulSet"):
        flags = server_flags.values(production.flags(server))
        assert {"tls_certificate", "tls_key", "tokens"} <= flags.keys()


def test_the_server_takes_all_flags(overlay: Overlay) -> None:
    (server,) = overlay.of_kind("StatefulSet")
    assert server_flags.complaint(overlay.flags(server)) == ""
