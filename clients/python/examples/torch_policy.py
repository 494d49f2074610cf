"""A recurrent policy in PyTorch, for procgen-evaluate.

    PYTHONPATH=clients/python/examples procgen-evaluate coinrun --mode easy \\
        --policy torch_policy:make_policy --option grayscale_obs=true

The variable POLICY_WEIGHTS names a file that ``torch.save(network.state_dict(), path)`` wrote;
without it the weights are random.
"""

from __future__ import annotations

import os
from collections.abc import Callable

import numpy as np
import torch
from torch import nn

import procgen_client


class RecurrentNetwork(nn.Module):
    """A small convolutional network with a GRU cell, which remembers the episode."""

    def __init__(self) -> None:
        """Makes random weights."""
        super().__init__()
        self.encoder = nn.Sequential(
            *(nn.Conv2d(1, 16, 8, stride=4), nn.ReLU(), nn.Conv2d(16, 32, 4, stride=2), nn.ReLU()),
            *(nn.Flatten(), nn.Linear(32 * 6 * 6, 128), nn.ReLU()),
        )
        self.memory = nn.GRUCell(128, 128)
        self.logits = nn.Linear(128, procgen_client.ACTION_COUNT)

    def forward(
        self, observations: torch.Tensor, hidden: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Returns logits [N, 15] and the next state [N, 128].

        Args:
            observations: uint8 [N, 64, 64, 1].
            hidden: The state after the previous step [N, 128].
        """
        hidden = self.memory(self.encoder(observations.permute(0, 3, 1, 2) / 255), hidden)
        return self.logits(hidden), hidden


def make_policy(game: str) -> Callable[..., np.ndarray]:
    """Returns the policy; procgen-evaluate calls it for each game and set of levels."""
    torch.manual_seed(0)
    network = RecurrentNetwork()
    path = os.environ.get("POLICY_WEIGHTS")
    if path is not None:
        network.load_state_dict(torch.load(path, weights_only=True))
    hidden = torch.zeros(0, 128)

    def act(observations: np.ndarray, first: np.ndarray) -> np.ndarray:
        """Samples actions; a new episode (`first`) starts without memory."""
        nonlocal hidden
        if len(hidden) != len(first):
            hidden = torch.zeros(len(first), 128)
        hidden[torch.from_numpy(first)] = 0
        with torch.no_grad():
            logits, hidden = network(torch.from_numpy(observations), hidden)
        actions: np.ndarray = torch.multinomial(logits.softmax(-1), 1).squeeze(-1).numpy()
        return actions

    return act
