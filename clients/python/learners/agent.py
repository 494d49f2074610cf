"""The agent of PPO: an actor and a critic with a shared encoder, and optionally a memory.

n: observations; k: frames in an observation, with k = 1 without their axis; H: MEMORY_SIZE.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from torch import nn
from torch.nn import functional as F  # noqa: N812 - the usual name

from learners.networks import make_encoder
from procgen_client import ACTION_COUNT

MEMORY_SIZE = 256  # Of the LSTM, as that of the paper's code.


class Agent(nn.Module):
    """An actor and a critic with a shared encoder, and with an LSTM between if `lstm`."""

    def __init__(self, options: Mapping[str, Any]) -> None:
        """Makes the network that the options of a run describe."""
        super().__init__()
        self.frame_stack: int = options["frame_stack"]
        self.encoder = make_encoder(
            *(options["network"], options["width"], getattr(torch, options["precision"])),
            *(options["init"], self.frame_stack),
        )
        feature_count = self.encoder.feature_count
        self.lstm = None
        if options["lstm"]:
            self.lstm = nn.LSTMCell(feature_count, MEMORY_SIZE)
            for name, parameter in self.lstm.named_parameters():
                (nn.init.orthogonal_ if name.startswith("weight") else nn.init.zeros_)(parameter)
            feature_count = MEMORY_SIZE
        self.policy = nn.Linear(feature_count, ACTION_COUNT)
        self.value = nn.Linear(feature_count, 1)
        for head, gain in ((self.policy, 0.01), (self.value, 1.0)):
            nn.init.orthogonal_(head.weight, gain)
            nn.init.zeros_(head.bias)

    def forward(
        self,
        observations: torch.Tensor,
        memory: torch.Tensor | None = None,
        first: torch.Tensor | None = None,
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor | None]:
        """Evaluates observations; with an LSTM, those of T steps of e environments, n = T * e.

        Args:
            observations: uint8 [n, k, 64, 64, 3]; row t * e + i is step t of environment i.
            memory: Before the first step, [2, e, H]. None: there is no LSTM.
            first: 1 if an observation is the first of its episode, else 0, float32 [T, e].

        Returns:
            logits [n, ACTION_COUNT], values [n], the memory after the last step.
        """
        features = self.encoder(observations)
        if self.lstm is not None:
            assert memory is not None
            assert first is not None
            outputs = []
            for x, alive in zip(features.view(*first.shape, -1), 1 - first[..., None], strict=True):
                memory = torch.stack(self.lstm(x, (memory[0] * alive, memory[1] * alive)))
                outputs.append(memory[0])
            features = torch.cat(outputs)
        return self.policy(features), self.value(features).squeeze(-1), memory


def sampled(log_probabilities: torch.Tensor, noise: torch.Tensor) -> torch.Tensor:
    """Samples actions [n] by the Gumbel-max trick.

    The largest of logits plus Gumbel noise is a sample of their softmax.

    Args:
        log_probabilities: [n, ACTION_COUNT].
        noise: Exponentially distributed, [n, ACTION_COUNT].
    """
    return (log_probabilities - noise.log()).argmax(-1)


class AgentPolicy:
    """Samples an agent's actions, and keeps the frames and the memory of its environments.

    Equal calls return equal actions.
    """

    def __init__(self, agent: Agent, seed: int = 0) -> None:
        """Takes the agent, whose weights may change between calls, and the seed of its samples."""
        self._agent = agent
        self._random = torch.Generator().manual_seed(seed)
        self._frames: np.ndarray | None = None  # uint8 [n, k, 64, 64, 3]; only if k > 1.
        self._memory: torch.Tensor | None = None  # [2, n, H]; only with an LSTM.

    def __call__(self, observations: np.ndarray, first: np.ndarray | None = None) -> np.ndarray:
        """Returns actions, int64 [n].

        Args:
            observations: One frame of each environment, uint8 [n, 64, 64, 3].
            first: Whether it is the first of an episode, bool [n]. None: of none.
        """
        return self.sample(self.evaluate(observations, first)[0])

    @torch.no_grad()
    def evaluate(
        self, observations: np.ndarray, first: np.ndarray | None = None
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Returns log-probabilities [n, ACTION_COUNT] and values [n]; arguments as of a call."""
        agent = self._agent
        first = np.zeros(len(observations), bool) if first is None else first
        device = agent.policy.weight.device
        frames = torch.from_numpy(self._stacked(observations, first)).to(device)
        if agent.lstm is None:
            logits, values, _ = agent(frames)
        else:
            memory = self._memory
            if memory is None:
                memory = torch.zeros(2, len(first), MEMORY_SIZE)
            starts = torch.from_numpy(np.float32(first)[None]).to(device)
            logits, values, self._memory = agent(frames, memory.to(device), starts)
        return F.log_softmax(logits, -1).cpu(), values.cpu()

    def sample(self, log_probabilities: torch.Tensor) -> np.ndarray:
        """Returns a sample of the actions, int64 [n]."""
        noise = torch.empty(log_probabilities.shape).exponential_(generator=self._random)
        actions: np.ndarray = sampled(log_probabilities, noise).numpy()
        return actions

    def state(self) -> dict[str, Any]:
        """Returns all state but the agent's, for a checkpoint."""
        return {
            "random": self._random.get_state(),
            "frames": self._frames,
            "memory": self._memory,
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continues from a checkpoint."""
        self._random.set_state(state["random"])
        self._frames, self._memory = state["frames"], state["memory"]

    def _stacked(self, observations: np.ndarray, first: np.ndarray) -> np.ndarray:
        """Adds a frame to the stacks; as in a pool, an episode starts with copies of one."""
        count = self._agent.frame_stack
        if count == 1:
            return observations
        copies = np.repeat(observations[:, None], count, 1)
        if self._frames is None:
            self._frames = copies
        moved = np.concatenate([self._frames[:, 1:], observations[:, None]], 1)
        self._frames = np.where(first[:, None, None, None, None], copies, moved)
        return self._frames
