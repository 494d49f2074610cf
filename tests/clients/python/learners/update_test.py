"""An update on the GPU's path gives the policy and the weights of PyTorch's layers on the CPU.

The path: merged columns, selected maxima, prepared kernels; on a GPU also graphs.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

torch = pytest.importorskip("torch")

from small_runs import options

from learners import networks, ppo
from learners.environments import Environments, environment_options
from learners.ranks import Ranks

# On the CPU the path is forced.
_DEVICES = ["cpu", *(["cuda"] if torch.cuda.is_available() else [])]
_PRECISIONS = ("float32", "bfloat16")
# On the CPU, too, with a version of PyTorch that compiles.
_COMPILED = (True, False) if hasattr(torch.nn.Module, "compile") else (False,)


@pytest.fixture(scope="module")
def environments() -> Iterator[Environments]:
    """Eight environments."""
    parsed = ppo.parse(options(Path(), None, num_envs=8))
    made = Environments("bigfish", 8, **environment_options(parsed, 0, 1))
    yield made
    made.close()


def _learner(
    environments: Environments, device: str, precision: str, *, compiled: bool
) -> ppo.Ppo:
    words = {"network": "impala", "num_envs": 8, "num_steps": 32, "epochs": 1, "chunk_size": 0}
    words |= {"device": device, "precision": precision, "compile": compiled}
    return ppo.Ppo(ppo.parse(options(Path(), None, **words)), Ranks("gloo"), environments)


def _moves(learner: ppo.Ppo, before: list[torch.Tensor]) -> list[torch.Tensor]:
    pairs = zip(learner.parameters, before, strict=True)
    return [after.detach().cpu() - old for after, old in pairs]


def _cosine(mine: torch.Tensor, its: torch.Tensor) -> float:
    return float(torch.cosine_similarity(mine.flatten(), its.flatten(), 0))


@pytest.mark.parametrize("device", _DEVICES)
@pytest.mark.parametrize("precision", _PRECISIONS)
@pytest.mark.parametrize("compiled", _COMPILED)
def test_update_on_the_path_of_a_gpu_equals_that_of_plain_layers(
    environments: Environments,
    monkeypatch: pytest.MonkeyPatch,
    device: str,
    precision: str,
    compiled: bool,  # noqa: FBT001 - a parameter of the test
) -> None:
    plain = _learner(environments, "cpu", "float32", compiled=False)
    plain.collector.collect()
    merged = _learner(environments, device, precision, compiled=compiled)
    if compiled and device == "cpu":
        merged.agent.compile(dynamic=False)
    merged.agent.load_state_dict(plain.agent.state_dict())
    before = [parameter.detach().cpu().clone() for parameter in plain.parameters]
    monkeypatch.setattr(networks, "merges_columns", lambda device: True)
    for mine, its in zip(merged.rollout, plain.rollout, strict=True):
        mine.copy_(its)

    merged.agent.encoder.prepare()
    with torch.no_grad():
        logits, values, _ = merged.agent(merged.rollout.observations)
    tolerance = {"float32": 1e-5, "bfloat16": 0.03}[precision]
    log_probabilities = torch.log_softmax(logits.cpu(), -1)
    chosen = log_probabilities.gather(-1, plain.rollout.actions[:, None]).squeeze(-1)
    assert (chosen - plain.rollout.log_probabilities).abs().max() < tolerance
    assert (values.cpu() - plain.rollout.values).abs().max() < tolerance * 10

    gradients, metrics = merged.minibatch_gradients(merged.rows)
    expected_gradients, expected_metrics = plain.minibatch_gradients(plain.rows)
    is_exact = precision == "float32"
    assert metrics.tolist() == pytest.approx(
        expected_metrics.tolist(), rel=1e-3 if is_exact else 0.2, abs=1e-5 if is_exact else 1e-3
    )
    for mine, its in zip(gradients, expected_gradients, strict=True):
        assert _cosine(mine.cpu(), its) > (0.99999 if is_exact else 0.9)

    metrics = merged.learn()
    monkeypatch.undo()
    expected = plain.learn()
    # Adam magnifies small gradients, and the second minibatch sees the weights after the first.
    if is_exact:
        assert metrics == pytest.approx(expected, rel=0.02, abs=1e-3)
    for mine, its in zip(_moves(merged, before), _moves(plain, before), strict=True):
        assert _cosine(mine, its) > (0.995 if is_exact else 0.7)
