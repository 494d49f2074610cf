"""deploy/monitoring uses exactly the metrics that a running server exports."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import grpc
import pytest
import yaml

from procgen_client import Client, ServerProcess, errors

_FOLDER = Path(__file__).resolve().parents[2] / "deploy" / "monitoring"
_DASHBOARD = json.loads((_FOLDER / "dashboard.json").read_text())
_RULES = [
    rule
    for group in yaml.safe_load((_FOLDER / "alerts.yaml").read_text())["groups"]
    for rule in group["rules"]
]
# Labels that Prometheus adds by itself.
_ADDED_LABELS = {"job", "instance"}

# Label names by metric.
Exported = dict[str, set[str]]


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Exported:
    """The metrics after a learner stepped a pool and failed."""
    log = tmp_path_factory.mktemp("server") / "log"
    with ServerProcess(flags=["--metrics_address=127.0.0.1:0"], log_path=log) as server:
        with Client(server.address) as client, client.create_pool("coinrun", 2) as pool:
            pool.step([7, 7])
            with pytest.raises(errors.NotFoundError):
                client.get_pool("pools/none")
        address = re.search(r"metrics=(\S+)", log.read_text()).group(1)
        with urllib.request.urlopen(f"http://{address}/metrics") as page:
            text = page.read().decode()
    metrics: Exported = {}
    for name, labels in re.findall(r"^(procgen_\w+)(?:\{(.*)\})? ", text, re.MULTILINE):
        metrics.setdefault(name, set()).update(re.findall(r"(\w+)=", labels))
    return metrics


def panels() -> list[dict[str, Any]]:
    return [panel for panel in _DASHBOARD["panels"] if panel["type"] != "row"]


def expressions() -> Iterator[str]:
    for panel in panels():
        yield from (target["expr"] for target in panel["targets"])
    yield from (rule["expr"] for rule in _RULES)
    for variable in _DASHBOARD["templating"]["list"]:
        if variable["type"] == "query":
            yield variable["query"]["query"]


def metrics_of(expression: str) -> set[str]:
    without_texts = re.sub(r'"[^"]*"', '""', expression)
    return set(re.findall(r"\bprocgen_\w+", without_texts))


def labels_of(expression: str) -> set[str]:
    grouped = ",".join(re.findall(r"by \(([^)]*)\)", expression)).replace(" ", "").split(",")
    matched = re.findall(r"[{,](\w+)[!=]", expression)
    return {*grouped, *matched} - {""}


def test_every_queried_metric_exists(exported: Exported) -> None:
    for expression in expressions():
        names = metrics_of(expression)
        assert names <= exported.keys(), expression
        known = set().union(*(exported[name] for name in names), _ADDED_LABELS)
        assert labels_of(expression) <= known, expression


def test_every_metric_is_on_the_dashboard(exported: Exported) -> None:
    shown = {re.sub(r"_(bucket|sum|count)$", "", n) for e in expressions() for n in metrics_of(e)}
    assert {re.sub(r"_(bucket|sum|count)$", "", name) for name in exported} == shown


def test_queried_error_codes_exist() -> None:
    texts = [t for e in expressions() for t in re.findall(r'code[!=~]+"([^"]*)"', e)]
    codes = {code for text in texts for code in text.split("|")}
    assert codes
    assert codes <= {code.name for code in grpc.StatusCode}


def test_panels_do_not_overlap() -> None:
    taken: set[tuple[int, int]] = set()
    for panel in _DASHBOARD["panels"]:
        place = panel["gridPos"]
        assert place["x"] + place["w"] <= 24
        cells = {
            (x, y)
            for x in range(place["x"], place["x"] + place["w"])
            for y in range(place["y"], place["y"] + place["h"])
        }
        assert not cells & taken, panel["title"]
        taken |= cells
    identifiers = [panel["id"] for panel in _DASHBOARD["panels"]]
    assert len(set(identifiers)) == len(identifiers)


def test_panels_use_the_selected_source_and_servers() -> None:
    for panel in panels():
        for target in panel["targets"]:
            assert target["datasource"]["uid"] == "${datasource}"
            for selector in re.findall(r"procgen_\w+(\{[^}]*\})?", target["expr"]):
                assert 'job=~"$job",instance=~"$instance"' in selector, panel["title"]


def test_each_alert_is_tested() -> None:
    tested = yaml.safe_load((_FOLDER / "alerts_test.yaml").read_text())["tests"]
    cases = [case for test in tested for case in test["alert_rule_test"]]
    names = {case["alertname"] for case in cases if case["exp_alerts"]}
    assert names == {rule["alert"] for rule in _RULES}


@pytest.mark.parametrize(
    "arguments", [("check", "config", "prometheus.yaml"), ("test", "rules", "alerts_test.yaml")]
)
def test_prometheus_accepts_the_rules(arguments: tuple[str, ...]) -> None:
    if shutil.which("promtool") is None:
        pytest.skip("there is no promtool; deploy/install-dependencies.sh --slow installs it")
    result = subprocess.run(
        ["promtool", *arguments], capture_output=True, text=True, check=False, cwd=_FOLDER
    )
    assert result.returncode == 0, result.stdout + result.stderr
