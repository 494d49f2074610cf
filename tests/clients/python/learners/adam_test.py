"""Adam takes the steps of PyTorch's Adam, with either epsilon, and continues from its state."""

from __future__ import annotations

import pytest

torch = pytest.importorskip("torch")

from learners.adam import BETAS, EPSILON, KINDS, Adam


def _parameters() -> list[torch.nn.Parameter]:
    torch.manual_seed(0)
    kernel = torch.randn(4, 3, 3, 3).to(memory_format=torch.channels_last)
    return [torch.nn.Parameter(each) for each in (kernel, torch.randn(5), torch.randn(2, 5))]


def _gradients(step: int) -> list[torch.Tensor]:
    torch.manual_seed(step)
    # Small ones, too, for which epsilon counts.
    return [torch.randn_like(each) * 10.0 ** (1 - step) for each in _parameters()]


@pytest.mark.parametrize("kind", KINDS)
def test_steps_are_those_of_pytorch(kind: str) -> None:
    mine, its = _parameters(), _parameters()
    adam = Adam(mine, 5e-4, kind)
    expected = torch.optim.Adam(its, 5e-4, eps=EPSILON)
    for step in range(1, 9):
        adam.step(_gradients(step))
        for parameter, gradient in zip(its, _gradients(step), strict=True):
            parameter.grad = gradient
        if kind == "tensorflow":
            expected.param_groups[0]["eps"] = EPSILON / (1 - BETAS[1] ** step) ** 0.5
        expected.step()
        for parameter, other in zip(mine, its, strict=True):
            torch.testing.assert_close(parameter, other, rtol=1e-6, atol=1e-7)


def test_step_continues_from_a_state_in_the_same_memory() -> None:
    parameters, others = _parameters(), _parameters()
    adam, other = Adam(parameters, 0.1, "tensorflow"), Adam(others, 0.1, "tensorflow")
    adam.step(_gradients(1))
    memory = [tensor.data_ptr() for tensor in other.tensors()]
    other.load_state_dict(adam.state_dict())
    with torch.no_grad():
        for mine, its in zip(others, parameters, strict=True):
            mine.copy_(its)
    for each in (adam, other):
        each.step(_gradients(2))
    assert all(torch.equal(*pair) for pair in zip(parameters, others, strict=True))
    assert [tensor.data_ptr() for tensor in other.tensors()] == memory
