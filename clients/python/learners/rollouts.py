"""Collection of rollouts: an agent acts in environments.

The environments are one pool in two halves: the server steps one half while the network processes
the other.

T: steps in a rollout; N: environments of this process; B = T * N; F: the shape of an observation,
[64, 64, 3], or with a stack of k frames [k, 64, 64, 3]; H: MEMORY_SIZE.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import torch
from torch.nn import functional as F  # noqa: N812 - the usual name

from learners.agent import MEMORY_SIZE, Agent, sampled
from learners.environments import Environments, Episode, episodes_of
from learners.networks import captured
from learners.training_run import Update
from procgen_client import ACTION_COUNT, NormalizeReward


class Rollout(NamedTuple):
    """T steps of N environments, flat: row t * N + i is step t of environment i."""

    observations: torch.Tensor  # uint8   [B, *F]
    actions: torch.Tensor  # int64   [B]
    log_probabilities: torch.Tensor  # Of the actions, at their choice   float32 [B]
    values: torch.Tensor  # Of the critic, at that time   float32 [B]
    advantages: torch.Tensor  # float32 [B]
    returns: torch.Tensor  # advantages + values   float32 [B]
    first: torch.Tensor  # Whether an observation is the first of its episode   float32 [B]
    memory: torch.Tensor  # Before the first step   float32 [2, N, H], without an LSTM [2, N, 0]


def estimate_advantages(
    rewards: torch.Tensor, ended: torch.Tensor, values: torch.Tensor, gamma: float, lambda_: float
) -> torch.Tensor:
    """Returns generalised advantage estimates, float32 [T, N], on the device of the arguments.

    As in the paper's code, the time limit ends an episode without a bootstrapped value.

    Args:
        rewards: float32 [T, N].
        ended: 1 if the step ended an episode, else 0, float32 [T, N].
        values: Of the observations before each step and after the last, float32 [T + 1, N].
        gamma: Discount.
        lambda_: Decay of the estimator.
    """
    alive = 1 - ended
    advantages = rewards + gamma * values[1:] * alive - values[:-1]
    decay = gamma * lambda_ * alive
    for t in reversed(range(len(rewards) - 1)):
        advantages[t].add_(decay[t] * advantages[t + 1])
    return advantages


class Collector:
    """The environments of a rank, the rollout that is collected in them, random generators."""

    def __init__(
        self, options: argparse.Namespace, environments: Environments, agent: Agent, seed: int
    ) -> None:
        """Takes the agent that acts, whose weights may change between rollouts."""
        self.options, self.environments, self.agent = options, environments, agent
        self.device = torch.device(options.device)
        self.normalize = NormalizeReward(options.num_envs, gamma=options.reward_gamma)
        self.random = torch.Generator(self.device).manual_seed(seed)
        shape = (options.num_steps + 1, options.num_envs)  # [T + 1, N]
        frames = (options.frame_stack,) if options.frame_stack > 1 else ()
        self.observations = torch.zeros(
            (*shape, *frames, 64, 64, 3), dtype=torch.uint8, device=self.device
        )
        # Whether an observation is the first of its episode, and the memory before it.
        self.first = torch.zeros(shape, device=self.device)
        self.memories = None
        if options.lstm:
            self.memories = torch.zeros(
                (shape[0] + 1, 2, shape[1], MEMORY_SIZE), device=self.device
            )
        self.noise = torch.ones((*shape, ACTION_COUNT), device=self.device)
        self.actions = torch.zeros(shape, dtype=torch.int64, device=self.device)
        self.log_probabilities = torch.zeros(shape, device=self.device)
        self.values = torch.zeros(shape, device=self.device)
        self.probabilities = torch.zeros(shape[1], ACTION_COUNT, device=self.device)
        self.rewards, self.ended, advantages, returns = torch.zeros(
            (4, shape[0] - 1, shape[1]), device=self.device
        )
        kept = (self.observations, self.actions, self.log_probabilities, self.values)
        rollout = [*(tensor[:-1] for tensor in kept), advantages, returns, self.first[:-1]]
        no_memory = torch.zeros(2, shape[1], 0, device=self.device)
        memory = no_memory if self.memories is None else self.memories[0]
        self.rollout = Rollout(*(tensor.flatten(0, 1) for tensor in rollout), memory)
        self.received = self.observations  # Where the client writes them.
        self.fill_returns, self.prepare = self.estimate_on_device, lambda: None
        if self.device.type == "cuda":
            self.received = torch.zeros(self.observations.shape[1:], dtype=torch.uint8)
            self.received = self.received.pin_memory()
            self.received_first = torch.zeros(shape[1]).pin_memory()
            self.chosen = torch.zeros(shape[1], dtype=torch.int64).pin_memory()
            self.steps = torch.arange(shape[0], device=self.device).split(1)  # [1] each.
            self.graphs = {
                rows.start: captured(partial(self.act_on_gpu, rows=rows))
                for rows in environments.halves
            }
            self.fill_returns = captured(self.estimate_on_device)
            self.prepare = captured(self.agent.encoder.prepare)

    def collect(self) -> Update:
        """Takes T steps, and fills the rollout."""
        step_count, env_count = self.options.num_steps, self.options.num_envs
        rewards = np.zeros((step_count, env_count), np.float32)
        ended = np.zeros((step_count, env_count), bool)
        episodes: list[Episode] = []
        environment_seconds = policy_seconds = 0.0
        self.noise.exponential_(generator=self.random)
        if self.memories is not None:
            self.memories[0] = self.memories[-2] * (1 - self.first[-1, :, None])
        self.prepare()
        clock = time.perf_counter
        begin = clock()
        sending = called(float)
        with ThreadPoolExecutor(1) as sender:
            submit = sender.submit if self.sends_in_background() else called
            for t, rows, batch in self.environments.rollout(step_count, out=self.received):
                received = clock()
                choice = self.choose(t, rows, batch.ended)
                sent = sending.result()  # The other half has its actions.
                sending = submit(self.send, choice, t, rows if t < step_count else None)
                waited = clock() - received
                environment_seconds += received - begin + min(sent, waited)
                policy_seconds += max(0, waited - sent)
                if t > 0:  # The first batch is an observation without a step.
                    rewards[t - 1, rows], ended[t - 1, rows] = batch.rewards, batch.ended
                    episodes += episodes_of(batch, t, rows.start)
                begin = clock()
        self.estimate_returns(rewards, ended)
        return Update(step_count, episodes, environment_seconds, policy_seconds, ())

    def sends_in_background(self) -> bool:
        """Returns whether a thread waits for a GPU's choices, while a half is received.

        Only pools in the process may be sent to meanwhile.
        """
        return self.device.type == "cuda" and not self.environments.can_be_watched

    def send(self, choice: Callable[[], np.ndarray], t: int, rows: slice | None) -> float:
        """Sends actions, unless `rows` is None, when chosen; returns the seconds of sending."""
        actions = choice()
        begin = time.perf_counter()
        if rows is not None:
            self.environments.send(actions, rows, annotations=self.annotations(t, rows))
        return time.perf_counter() - begin

    def annotations(self, t: int, rows: slice) -> dict[str, np.ndarray]:
        """Returns what viewers of a server see beside step t, and what is recorded with it."""
        if not self.environments.can_be_watched:
            return {}
        return {
            "value": self.values[t, rows].cpu().numpy(),
            "action_probabilities": self.probabilities[rows].cpu().numpy(),
        }

    def choose(self, t: int, rows: slice, first: np.ndarray) -> Callable[[], np.ndarray]:
        """Starts to choose the actions of step t; the result waits for them, int64 [rows].

        `first` [rows]: whether their observations are the first of an episode.
        """
        received = self.first[t, rows] if self.device.type != "cuda" else self.received_first[rows]
        received.copy_(torch.from_numpy(first))
        if self.device.type != "cuda":
            return self.act(t, rows).numpy
        self.graphs[rows.start](self.steps[t])
        chosen = torch.cuda.Event()
        chosen.record()

        def wait() -> np.ndarray:
            chosen.synchronize()
            return self.chosen[rows].numpy()

        return wait

    def act(self, t: int | torch.Tensor, rows: slice) -> torch.Tensor:
        """Chooses the actions of step t, an integer or int64 [1], and keeps the choice."""
        memory = first = None
        if self.memories is not None:
            first = self.first[t, rows].view(1, -1)
            memory = self.memories[t, :, rows].view(2, -1, MEMORY_SIZE)
        with torch.no_grad():
            observations = self.observations[t, rows].view(-1, *self.observations.shape[2:])
            logits, self.values[t, rows], memory = self.agent(observations, memory, first)
            log_softmax = F.log_softmax(logits, -1)
            actions = sampled(log_softmax, self.noise[t, rows].view(-1, ACTION_COUNT))
            self.actions[t, rows] = actions
            self.probabilities[rows] = log_softmax.exp()
            chosen = log_softmax.gather(-1, actions[:, None]).squeeze(-1)
            self.log_probabilities[t, rows] = chosen
            if self.memories is not None:
                self.memories[t + 1, :, rows] = memory
        return actions

    def act_on_gpu(self, t: torch.Tensor, rows: slice) -> None:
        """Copies received observations to the GPU, and chooses and copies actions, as a graph."""
        self.observations[t, rows] = self.received[rows].to(self.device, non_blocking=True)
        self.first[t, rows] = self.received_first[rows].to(self.device, non_blocking=True)
        self.chosen[rows].copy_(self.act(t, rows), non_blocking=True)

    def estimate_returns(self, rewards: np.ndarray, ended: np.ndarray) -> None:
        """Fills in advantages and returns; the last observation has only a value."""
        normalized = np.stack([*map(self.normalize, rewards, ended)])
        self.rewards.copy_(torch.from_numpy(normalized))
        self.ended.copy_(torch.from_numpy(ended))
        self.fill_returns()

    def estimate_on_device(self) -> None:
        """Fills in advantages and returns, from rewards and ended on the device."""
        advantages = estimate_advantages(
            *(self.rewards, self.ended, self.values),
            *(self.options.gamma, self.options.gae_lambda),
        )
        self.rollout.advantages.copy_(advantages.flatten())
        torch.add(self.rollout.advantages, self.rollout.values, out=self.rollout.returns)

    def state(self) -> dict[str, Any]:
        """Returns all state but the agent's, for a checkpoint."""
        return {
            "normalizer": self.normalize.state_dict(),
            "random": self.random.get_state(),
            "states": self.environments.pool.save_states(),
            "first": self.first[-1],
            "memory": None if self.memories is None else self.memories[-2],
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Continues from a checkpoint."""
        self.normalize.load_state_dict(state["normalizer"])
        self.random.set_state(state["random"])
        self.environments.pool.restore_states(state["states"])
        self.first[-1] = state["first"]
        if self.memories is not None:
            self.memories[-2] = state["memory"]


def called(function: Callable[..., float], *arguments: Any) -> Future[float]:  # noqa: ANN401
    """Calls a function; returns the result as ThreadPoolExecutor.submit does."""
    future: Future[float] = Future()
    future.set_result(function(*arguments))
    return future
