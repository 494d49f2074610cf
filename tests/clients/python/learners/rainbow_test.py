"""Rainbow resumes without changes, and its parts follow the papers."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from small_runs import STEPS_OF_UPDATE, RestartedEnvironments, train_rainbow

from learners import rainbow
from procgen_client import ServerProcess

torch = pytest.importorskip("torch")


@pytest.fixture(scope="module")
def uninterrupted(
    server: ServerProcess, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, str]:
    """The results of four updates."""
    return train_rainbow(tmp_path_factory.mktemp("uninterrupted"), server.address)


def test_each_update_writes_a_row(uninterrupted: dict[str, str]) -> None:
    rows = uninterrupted["learning"].splitlines()
    assert rows[0] == "step,loss,q_mean"
    assert len(rows) == 5
    assert len(uninterrupted["episodes"].splitlines()) > 1


def test_equal_seeds_give_equal_runs(
    server: ServerProcess, uninterrupted: dict[str, str], tmp_path: Path
) -> None:
    assert train_rainbow(tmp_path / "same", threads=1) == uninterrupted
    assert train_rainbow(tmp_path / "other", seed=1) != uninterrupted


def test_run_stopped_after_each_update_equals_an_uninterrupted_run(
    server: ServerProcess, uninterrupted: dict[str, str], tmp_path: Path
) -> None:
    for _ in range(4):
        stopped = train_rainbow(tmp_path, time_limit=0, resume=True)
    assert stopped == uninterrupted


def test_restarts_of_the_server_do_not_change_a_run(
    uninterrupted: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rainbow, "Environments", RestartedEnvironments)
    with RestartedEnvironments.server_to_restart() as address:
        assert train_rainbow(tmp_path, address) == uninterrupted
    assert RestartedEnvironments.restarts == 4


def test_all_linear_layers_are_noisy_and_fruitbot_has_returns_from_minus_5(
    tmp_path: Path,
) -> None:
    train_rainbow(tmp_path, game="fruitbot", total_steps=STEPS_OF_UPDATE)
    options = json.loads((tmp_path / "run.json").read_text())["options"]
    assert (options["value_min"], options["value_max"]) == (-5, 32.4)
    network = rainbow.QNetwork(options)
    assert not [layer for layer in network.modules() if isinstance(layer, torch.nn.Linear)]
    sizes = [tuple(layer.weight.shape) for layer in network.noisy_layers()]
    assert sizes == [(512, 1024), (51, 512), (512, 1024), (15 * 51, 512)]


def test_run_is_not_continued_without_its_replay(server: ServerProcess, tmp_path: Path) -> None:
    train_rainbow(tmp_path, time_limit=0)
    (tmp_path / "replay.bin").unlink()
    with pytest.raises(SystemExit, match=r"replay\.bin is missing"):
        train_rainbow(tmp_path, resume=True)


def test_projection_preserves_the_mean_within_the_range() -> None:
    atoms = torch.linspace(-1, 3, 9)
    probabilities = torch.softmax(torch.randn(4, 9, generator=torch.manual_seed(0)), -1)
    returns = torch.tensor([0.3, 0.0, -9.0, 1.25])
    discounts = torch.tensor([0.5, 0.0, 0.9, 0.0])
    projected = rainbow.project(probabilities, atoms, returns, discounts)
    assert torch.allclose(projected.sum(-1), torch.ones(4))
    wanted = (returns + discounts * (probabilities @ atoms)).clamp(-1, 3)
    assert torch.allclose(projected @ atoms, wanted, atol=1e-5)
    assert projected[2].tolist() == pytest.approx([1] + [0] * 8)


def test_noisy_layer_is_linear_without_noise_and_random_with_it() -> None:
    layer = rainbow.NoisyLinear(8, 4)
    x = torch.ones(1, 8)
    plain = torch.nn.functional.linear(x, layer.weight, layer.bias)
    assert torch.equal(layer(x), plain)
    random = torch.Generator().manual_seed(0)
    outputs = []
    for _ in range(2000):
        layer.resample(random)
        outputs.append(layer(x))
    outputs = torch.cat(outputs)
    assert torch.allclose(outputs.mean(0), plain[0], atol=0.05)
    assert (outputs.std(0) > 0.1).all()
