"""The layers for GPUs compute what PyTorch's layers compute, and so do their gradients."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import torch
from torch.nn import functional as F  # noqa: N812 - the usual name

from learners.gradients import ChunkedGradients
from learners.networks import Convolution, MaxPool, captured, make_encoder

Function = Callable[[torch.Tensor], torch.Tensor]


def _assert_equal(
    expected: Function, actual: Function, x: torch.Tensor, *parameters: torch.Tensor
) -> None:
    x = x.double().to(memory_format=torch.channels_last).requires_grad_()
    results = expected(x), actual(x)
    torch.testing.assert_close(results[1], results[0])
    assert results[1].is_contiguous(memory_format=torch.channels_last)
    weights = torch.randn_like(results[0])
    gradients = [torch.autograd.grad(y, [x, *parameters], weights) for y in results]
    torch.testing.assert_close(gradients[1], gradients[0])


@pytest.mark.parametrize(
    ("in_channels", "out_channels", "columns"),
    [(3, 16, 4), (3, 64, 4), (12, 16, 4), (16, 16, 2), (16, 32, 2), (32, 32, 2), (64, 64, 1)],
)
def test_merged_columns_give_the_same_convolution(
    in_channels: int, out_channels: int, columns: int
) -> None:
    torch.manual_seed(0)
    layer = Convolution(in_channels, out_channels).double()
    assert layer.columns == columns
    x = torch.randn(2, in_channels, 16, 8)
    _assert_equal(
        *(layer, lambda x: layer.merged(x, *layer.merged_parameters())),
        *(x, layer.weight, layer.bias),
    )
    x = x.double().contiguous(memory_format=torch.channels_last)
    for _ in range(2):  # The second time, in place.
        with torch.no_grad():
            layer.weight *= 2
            layer.bias -= 1
        layer.prepare(torch.float64)
        torch.testing.assert_close(layer.merged(x, *layer.prepared), layer(x))


def test_selected_maxima_are_those_of_max_pool() -> None:
    torch.manual_seed(0)
    pixels = torch.randint(0, 3, (4, 5, 16, 8))  # Nearly every window has several maxima.
    _assert_equal(lambda x: F.max_pool2d(x, 3, 2, 1), MaxPool.selected, pixels)


def test_impala_has_uniform_glorot_weights_and_no_biases() -> None:
    torch.manual_seed(0)
    layers = [
        layer
        for layer in make_encoder("impala", 1, torch.float32).modules()
        if isinstance(layer, torch.nn.Conv2d | torch.nn.Linear)
    ]
    assert len(layers) == 3 * 5 + 1
    for layer in layers:
        area = layer.weight[0, 0].numel()
        bound = (6 / (area * sum(layer.weight.shape[:2]))) ** 0.5
        assert 0.95 * bound < layer.weight.abs().max() <= bound
        assert layer.weight.std().item() == pytest.approx(bound / 3**0.5, rel=0.1)
        assert not layer.bias.any()


def test_gradients_have_the_layout_of_their_parameter() -> None:
    parameter = torch.randn(4, 3, 3, 3).to(memory_format=torch.channels_last).requires_grad_()

    def loss(x: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        total = (parameter.contiguous() * x).sum()
        return total, total.detach()

    x = torch.randn(6, 4, 3, 3, 3)
    (gradient,), _ = ChunkedGradients([parameter], 2, 1)(loss, x)
    assert gradient.stride() == parameter.stride()
    torch.testing.assert_close(gradient, x.mean(0))


@pytest.mark.skipif(not torch.cuda.is_available(), reason="there is no GPU")
def test_graph_that_changes_tensors_does_so_once_a_call() -> None:
    total = torch.zeros(3, device="cuda")

    def add(x: torch.Tensor) -> torch.Tensor:
        return total.add_(x) * 2

    call = captured(add, [total])
    for count in range(1, 4):
        doubled = call(torch.ones(3, device="cuda"))
        assert total.tolist() == [count] * 3
        assert doubled.tolist() == [2 * count] * 3
