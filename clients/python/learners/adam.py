"""Adam whose steps are operations on the device only, so that a CUDA graph can contain them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import torch

BETAS = 0.9, 0.999
EPSILON = 1e-5
KINDS = ("tensorflow", "pytorch")


class Adam:
    """Adam (Kingma and Ba, 2015) with epsilon as in TensorFlow or as in PyTorch.

    TensorFlow adds epsilon before it corrects the bias of the second moment.
    """

    def __init__(
        self, parameters: Sequence[torch.nn.Parameter], learning_rate: float, kind: str
    ) -> None:
        """Takes the parameters, of one device, and one of KINDS."""
        self._parameters = parameters
        self._learning_rate = learning_rate
        self._kind = kind
        count = sum(parameter.numel() for parameter in parameters)
        device = parameters[0].device
        # Moments of all parameters. A moment has few kernels then, instead of one per parameter.
        self.mean, self.square = torch.zeros(2, count, device=device)
        self._betas = torch.tensor(BETAS, dtype=torch.float64, device=device)
        self.step_count = torch.zeros((), dtype=torch.float64, device=device)

    @torch.no_grad()
    def step(self, gradients: Sequence[torch.Tensor]) -> None:
        """Changes the parameters in place; `gradients` are in their order."""
        gradient = torch.cat([each.flatten() for each in gradients])
        self.step_count += 1
        mean_correction, square_correction = 1 - self._betas**self.step_count
        self.mean.mul_(BETAS[0]).add_(gradient, alpha=1 - BETAS[0])
        self.square.mul_(BETAS[1]).addcmul_(gradient, gradient, value=1 - BETAS[1])
        root = square_correction.sqrt()
        epsilon = EPSILON / root if self._kind == "tensorflow" else EPSILON
        change = self.mean * (-self._learning_rate / mean_correction)
        change /= (self.square.sqrt() / root).add_(epsilon)
        parts = change.split([parameter.numel() for parameter in self._parameters])
        for parameter, part in zip(self._parameters, parts, strict=True):
            parameter.add_(part.view(parameter.shape))

    def tensors(self) -> list[torch.Tensor]:
        """Returns the tensors that a step changes."""
        return [*self._parameters, self.mean, self.square, self.step_count]

    def state_dict(self) -> dict[str, Any]:
        """Returns the state, for a checkpoint."""
        return {"mean": self.mean, "square": self.square, "step_count": self.step_count}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continues from a checkpoint, in the same memory."""
        for name, mine in self.state_dict().items():
            mine.copy_(state[name])
