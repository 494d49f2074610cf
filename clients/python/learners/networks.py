"""Convolutional encoders of the paper (Cobbe et al., 2020): IMPALA and Nature CNN.

Both map observations, uint8 [n, 64, 64, 3], to features, float32 [n, feature_count]. Observations
of k > 1 frames are [n, k, 64, 64, 3].
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import torch
from torch import nn
from torch.nn import functional as F  # noqa: N812 - the usual name

DENSE_SIZES = {"impala": 256, "nature": 512}
NETWORKS = tuple(DENSE_SIZES)
INITS = ("glorot", "pytorch")


is_eager = False  # Whether a GPU uses PyTorch's layers without graphs, to find errors.


def merges_columns(device: torch.device) -> bool:
    """Returns whether layers compute as on a GPU; tests compare both ways on one device."""
    return device.type == "cuda" and not is_eager


class Encoder(nn.Module):
    """Casts pixels, runs the layers in `precision`, and returns float32 features.

    Weights are float32 with either precision; bfloat16 applies to activations and products. The
    layout is channels-last, as that of observations.

    Attributes:
        feature_count: Number of features of an observation.
    """

    def __init__(self, layers: nn.Sequential, feature_count: int, precision: torch.dtype) -> None:
        """Takes the layers, from pixels in [0, 1], [n, 3 * k, 64, 64], to features."""
        super().__init__()
        self.layers = layers.to(memory_format=torch.channels_last)
        self.feature_count = feature_count
        self.precision = precision

    def prepare(self) -> None:
        """Prepares :meth:`forward` without gradients; call it after each change of the weights."""
        for layer in self.modules():
            if isinstance(layer, Convolution):
                layer.prepare(self.precision)

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Returns features, float32 [n, feature_count], of uint8 [n, k, 64, 64, 3]."""
        if observations.dim() == 5:
            observations = observations.movedim(1, 3).flatten(3)
        pixels = observations.permute(0, 3, 1, 2).to(self.precision).mul_(1 / 255)
        # Autocast can be captured in a CUDA graph only without its cache of weights.
        with torch.autocast(
            observations.device.type,
            torch.bfloat16,
            enabled=self.precision == torch.bfloat16,
            cache_enabled=False,
        ):
            return self.layers(pixels).float()


class Convolution(nn.Conv2d):
    """A 3 x 3 convolution. A GPU computes several columns as one, with a sparse kernel.

    Adjacent columns of a channels-last image are one column with more channels, without a copy.
    Tensor cores compute this faster, because they need at least 32 channels.
    """

    def __init__(self, in_channels: int, out_channels: int) -> None:
        """Takes the number of input and output channels."""
        super().__init__(in_channels, out_channels, 3, padding=1)
        self.columns = 4 if in_channels < 16 else 2 if in_channels < 64 else 1
        # Kernels need multiples of 8 channels: 16 of 4 columns, not 12.
        self.padding_channels = 1 if in_channels == 3 else 0
        self.prepared: list[torch.Tensor] = []

    @torch.no_grad()
    def prepare(self, precision: torch.dtype) -> None:
        """Keeps kernel and bias of the merged columns, for forward passes without gradients."""
        kernel, bias = (parameter.to(precision) for parameter in self.merged_parameters())
        kernel = kernel.contiguous(memory_format=torch.channels_last)
        if self.prepared:  # CUDA graphs use the same memory for each call.
            for mine, new in zip(self.prepared, (kernel, bias), strict=True):
                mine.copy_(new)
        else:
            self.prepared = [kernel, bias]

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Returns [n, out_channels, h, w] of x [n, in_channels, h, w]."""
        if not merges_columns(x.device):
            return super().forward(x)
        if self.prepared and not torch.is_grad_enabled():
            return self.merged(x, *self.prepared)
        return self.merged(x, *self.merged_parameters())

    def merged_parameters(self) -> tuple[torch.Tensor, torch.Tensor]:
        """Returns kernel and bias of the convolution with merged columns."""
        if self.columns == 1:
            return self.weight, self.bias
        weight = F.pad(self.weight, (0, 0, 0, 0, 0, self.padding_channels))
        return merged_kernel(weight, self.columns), self.bias.repeat(self.columns)

    def merged(self, x: torch.Tensor, kernel: torch.Tensor, bias: torch.Tensor) -> torch.Tensor:
        """Returns the same, computed with merged columns."""
        n, _, h, w = x.shape
        merged = F.pad(x.permute(0, 2, 3, 1), (0, self.padding_channels))
        merged = merged.reshape(n, h, w // self.columns, -1).permute(0, 3, 1, 2)
        y = F.conv2d(merged, kernel, bias, padding=1)
        return y.permute(0, 2, 3, 1).reshape(n, h, w, -1).permute(0, 3, 1, 2)


def merged_kernel(weight: torch.Tensor, columns: int) -> torch.Tensor:
    """Returns the kernel of a convolution with merged columns.

    Args:
        weight: [out_channels, in_channels, 3, 3].
        columns: Number of columns that are one.

    Returns:
        [columns * out_channels, columns * in_channels, 3, 3].
    """
    # Output column i reads columns i - 1 to i + 1 of the 3 * columns from -columns.
    padded = [F.pad(weight, (columns - 1 + i, 2 * columns - 2 - i)) for i in range(columns)]
    kernel = torch.stack(padded).unflatten(-1, (3, columns))  # [columns, out, in, 3, 3, columns]
    return kernel.permute(0, 1, 5, 2, 3, 4).flatten(2, 3).flatten(0, 1)


class MaxPool(nn.MaxPool2d):
    """Maxima of 3 x 3 pixels at every second column and row.

    A GPU selects them by columns, then by rows: compiled, that is faster than nn.MaxPool2d, whose
    gradient takes a sixth of an update. Both are equal, also where several pixels are the maximum.
    """

    def __init__(self) -> None:
        """Makes the layer."""
        super().__init__(3, stride=2, padding=1)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Returns [n, channels, h / 2, w / 2] of x [n, channels, h, w]; h and w are even."""
        return self.selected(x) if merges_columns(x.device) else super().forward(x)

    @staticmethod
    def selected(x: torch.Tensor) -> torch.Tensor:
        """Returns the same, selected by columns, then by rows."""
        x = x.permute(0, 2, 3, 1)
        even, odd = x[:, :, 0::2], x[:, :, 1::2]
        before = F.pad(odd[:, :, :-1], (0, 0, 1, 0), value=-torch.inf)
        x = first_larger(first_larger(before, even), odd)
        even, odd = x[:, 0::2], x[:, 1::2]
        before = F.pad(odd[:, :-1], (0, 0, 0, 0, 1, 0), value=-torch.inf)
        return first_larger(first_larger(before, even), odd).permute(0, 3, 1, 2)


def first_larger(first: torch.Tensor, second: torch.Tensor) -> torch.Tensor:
    """Returns the maximum; where both are equal, only `first` gets the gradient."""
    return torch.where(first >= second, first, second)


class ResidualBlock(nn.Module):
    """Two 3 x 3 convolutions with a shortcut."""

    def __init__(self, channels: int) -> None:
        """Takes the number of input and output channels."""
        super().__init__()
        self.first = Convolution(channels, channels)
        self.second = Convolution(channels, channels)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Returns x plus the output of the convolutions."""
        return x + self.second(F.relu(self.first(F.relu(x))))


def make_encoder(
    name: str,
    width: int,
    precision: torch.dtype,
    init: str = "glorot",
    frames: int = 1,
    *,
    dense: bool = True,
) -> Encoder:
    """Makes an encoder.

    Args:
        name: One of NETWORKS.
        width: Factor of the number of channels; 1, 2 or 4 in the paper.
        precision: torch.float32 or torch.bfloat16.
        init: Initial weights of IMPALA: "glorot", uniform with biases of 0, or PyTorch's own.
        frames: Number of frames in an observation, k.
        dense: Whether it ends with a linear layer of DENSE_SIZES[name] features.
    """
    layers = (_impala if name == "impala" else _nature)(width, 3 * frames)
    if name == "impala" and init == "glorot":
        for layer in nn.Sequential(*layers).modules():
            if isinstance(layer, nn.Conv2d | nn.Linear):
                nn.init.xavier_uniform_(layer.weight)
                nn.init.zeros_(layer.bias)
    feature_count = DENSE_SIZES[name]
    if not dense:
        *layers, linear, _ = layers
        feature_count = linear.in_features
    return Encoder(nn.Sequential(*layers), feature_count, precision)


def _impala(width: int, in_channels: int) -> list[nn.Module]:
    """Three stages that halve the resolution, each with two residual blocks (Espeholt et al.)."""
    layers: list[nn.Module] = []
    for channels in (16 * width, 32 * width, 32 * width):
        layers += [
            Convolution(in_channels, channels),
            MaxPool(),
            ResidualBlock(channels),
            ResidualBlock(channels),
        ]
        in_channels = channels
    return [*layers, nn.Flatten(), nn.ReLU(), nn.Linear(in_channels * 8 * 8, 256), nn.ReLU()]


def _nature(width: int, in_channels: int) -> list[nn.Module]:
    """Three convolutions and a linear layer (Mnih et al., 2015), on colour at 64 x 64."""
    layers = [
        nn.Conv2d(in_channels, 32 * width, 8, stride=4),
        nn.Conv2d(32 * width, 64 * width, 4, stride=2),
        nn.Conv2d(64 * width, 64 * width, 3),
        nn.Linear(64 * width * 4 * 4, 512),
    ]
    for layer in layers:
        nn.init.orthogonal_(layer.weight, 2**0.5)
        nn.init.zeros_(layer.bias)
    first, second, third, linear = layers
    return [
        *(first, nn.ReLU(), second, nn.ReLU(), third, nn.ReLU()),
        *(nn.Flatten(), linear, nn.ReLU()),
    ]


def default_precision(device: torch.device) -> torch.dtype:
    """Returns bfloat16 if the device multiplies it faster than float32, else float32."""
    if device.type == "cuda":
        return torch.bfloat16
    try:
        with open("/proc/cpuinfo") as cpuinfo:
            text = cpuinfo.read()
    except OSError:
        return torch.float32
    return torch.bfloat16 if "avx512_bf16" in text or "amx_bf16" in text else torch.float32


def captured(
    function: Callable[..., Any], changed: Sequence[torch.Tensor] = ()
) -> Callable[..., Any]:
    """Captures a function of tensors as CUDA graphs, so that a call is one launch.

    The first call with arguments of other shapes captures another graph. A graph uses the same
    memory for each call: results are valid until the next call. It uses the current values of
    parameters that are changed in place, as optimisers do.

    Args:
        function: Launches kernels only, and does not wait for the GPU.
        changed: Tensors on whose values its effect depends and which it changes: they are restored
            after the calls before a capture.
    """
    if is_eager:
        return function
    graphs: dict[tuple[torch.Size, ...], Callable[..., Any]] = {}

    def call(*arguments: torch.Tensor) -> Any:  # noqa: ANN401
        shapes = tuple(argument.shape for argument in arguments)
        if shapes not in graphs:
            graphs[shapes] = _capture(function, arguments, changed)
        return graphs[shapes](*arguments)

    return call


def _capture(
    function: Callable[..., Any],
    arguments: tuple[torch.Tensor, ...],
    changed: Sequence[torch.Tensor],
) -> Callable[..., Any]:
    inputs = [argument.clone() for argument in arguments]
    before = [tensor.detach().clone() for tensor in changed]
    stream = torch.cuda.Stream()
    stream.wait_stream(torch.cuda.current_stream())
    with torch.cuda.stream(stream):
        for _ in range(3):  # Libraries select their kernels before the capture.
            function(*inputs)
    torch.cuda.current_stream().wait_stream(stream)
    with torch.no_grad():
        for tensor, value in zip(changed, before, strict=True):
            tensor.copy_(value)
    graph = torch.cuda.CUDAGraph()
    with torch.cuda.graph(graph):
        outputs = function(*inputs)

    def replay(*arguments: torch.Tensor) -> Any:  # noqa: ANN401
        for its_input, argument in zip(inputs, arguments, strict=True):
            its_input.copy_(argument)
        graph.replay()
        return outputs

    return replay
