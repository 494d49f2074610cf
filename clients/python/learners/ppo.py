"""PPO with the hyperparameters of the Procgen paper (Cobbe et al., 2020), on a Procgen Server.

    python3 -m learners.ppo --game coinrun --mode easy --levels 200 --output runs/coinrun
    torchrun --nproc_per_node 2 -m learners.ppo --game coinrun --output runs/coinrun

The checkpoint has the complete state of a run, so a run that is stopped and continued
(--resume) equals an uninterrupted one; on a CPU, bit for bit.
"""

from __future__ import annotations

import argparse
import copy
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import torch
from torch import nn
from torch.nn import functional as F  # noqa: N812 - the usual name

from learners.adam import KINDS, Adam
from learners.agent import Agent, AgentPolicy
from learners.environments import Environments, environment_options
from learners.evaluation import PeriodicEvaluation
from learners.gradients import ChunkedGradients
from learners.networks import captured
from learners.options import parsed, run_parser, set_device
from learners.ranks import Ranks
from learners.rollouts import Collector, Rollout, called
from learners.training_run import TrainingRun, Update
from procgen_client.errors import ProcgenError


class Ppo:
    """The algorithm of one rank: agent, optimiser, collector of rollouts."""

    metric_names = (
        *("policy_loss", "value_loss", "entropy", "kl", "clip_fraction", "explained_variance"),
    )
    needs_checkpoint = False

    def __init__(
        self, options: argparse.Namespace, ranks: Ranks, environments: Environments
    ) -> None:
        """Starts with a new agent."""
        self.options, self.ranks = options, ranks
        self.device = torch.device(options.device)
        on_gpu = self.device.type == "cuda"
        torch.manual_seed(options.seed)
        self.agent = Agent(vars(options)).to(self.device)
        self.policy = AgentPolicy(self.agent)  # For tests during the training.
        self.parameters = list(self.agent.parameters())
        self.optimizer = Adam(self.parameters, options.learning_rate, options.adam)
        # The agent that acts. With a lag, its weights are those of before an update.
        self.actor = copy.deepcopy(self.agent) if options.policy_lag else self.agent
        if on_gpu and options.compile:
            # Compiled twice: for the rows of a half and for those of a minibatch.
            for agent in dict.fromkeys((self.agent, self.actor)):
                (agent.encoder if options.lstm else agent).compile(dynamic=False)
        # The device's generator is for actions, the host's for minibatches.
        seed = options.seed + 1_000_003 * ranks.rank
        self.host_random = torch.Generator().manual_seed(seed)
        self.collector = Collector(options, environments, self.actor, seed)
        self.rollout = self.collector.rollout
        if options.policy_lag:
            self.rollout = Rollout(*(tensor.clone() for tensor in self.rollout))
            self.has_rollout = self.has_learned = False
            self.stream = torch.cuda.Stream(self.device) if on_gpu else None
        # With a memory, minibatches consist of environments, each with all of its steps.
        self.row_count_of_index = options.num_steps if options.lstm else 1
        self.rows = torch.arange(len(self.rollout.actions), device=self.device)
        chunk_size = options.chunk_size and max(1, options.chunk_size // self.row_count_of_index)
        self.chunked = ChunkedGradients(
            self.parameters, chunk_size, 1 if on_gpu else options.threads
        )
        self.gradients, self.optimize = self.minibatch_gradients, self.step_on_minibatch
        if on_gpu and ranks.count == 1:
            self.optimize = captured(self.step_on_minibatch, self.optimizer.tensors())
        elif on_gpu:  # Averages of ranks are no part of a graph.
            self.gradients = captured(self.minibatch_gradients)

    def update(self) -> Update:
        """Collects a rollout and learns from it."""
        if self.options.policy_lag:
            return self.update_with_lag()
        update = self.collector.collect()._replace(metrics=self.learn())
        self.collector.prepare()  # For tests of the agent.
        return update

    def update_with_lag(self) -> Update:
        """Collects a rollout with the weights of before, and meanwhile learns from the last one."""
        with torch.no_grad():
            for mine, its in zip(self.actor.parameters(), self.parameters, strict=True):
                mine.copy_(its)
        with ThreadPoolExecutor(1) as thread:
            # At first in turn: others must not use a GPU while graphs are captured.
            submit = thread.submit if self.has_learned else called
            learning = submit(self.learn_on_stream)
            update = self.collector.collect()._replace(metrics=learning.result())
        for mine, its in zip(self.rollout, self.collector.rollout, strict=True):
            mine.copy_(its)
        self.has_rollout = True
        return update

    def learn_on_stream(self) -> list[float]:
        """As learn, on a GPU beside other work there. NaN: there is no rollout yet."""
        if not self.has_rollout:
            return [float("nan")] * len(self.metric_names)
        self.has_learned = True
        if self.stream is None:
            return self.learn()
        self.stream.wait_stream(torch.cuda.default_stream(self.device))
        with torch.cuda.stream(self.stream):
            return self.learn()

    def learn(self) -> list[float]:
        """Optimises the agent on the rollout; returns metric_names, means over minibatches."""
        sums = torch.zeros(len(self.metric_names) - 1, device=self.device)
        # Of the returns, by the critic that acted.
        explained = 1 - self.rollout.advantages.var() / self.rollout.returns.var()
        size = len(self.rollout.actions)
        index_count = size // self.row_count_of_index
        orders = [
            torch.randperm(index_count, generator=self.host_random)
            for _ in range(self.options.epochs)
        ]
        # Copied together: the host waits for a GPU here and for the metrics, not in between.
        for order in torch.stack(orders).to(self.device):
            for indices in order.chunk(self.options.minibatches):
                sums += self.optimize(indices)
        return [*(sums / (size * self.options.epochs)).tolist(), float(explained)]

    def step_on_minibatch(self, indices: torch.Tensor) -> torch.Tensor:
        """Takes an optimiser step on a minibatch; returns the sums of its metrics.

        `indices`: of rows of the rollout; with a memory, of environments.
        """
        gradients, metrics = self.gradients(indices)
        self.ranks.average(gradients)
        for parameter, gradient in zip(self.parameters, gradients, strict=True):
            parameter.grad = gradient
        nn.utils.clip_grad_norm_(self.parameters, self.options.max_grad_norm)
        self.optimizer.step([parameter.grad for parameter in self.parameters])
        return metrics

    def minibatch_gradients(
        self, indices: torch.Tensor
    ) -> tuple[list[torch.Tensor], torch.Tensor]:
        """Returns the gradients of a minibatch and the sums of its metrics."""
        advantages = self.rollout.advantages[self.rows_of(indices)]
        loss = partial(self.loss, mean=advantages.mean(), deviation=advantages.std() + 1e-8)
        gradients, metrics = self.chunked(loss, indices)
        return gradients, torch.stack(metrics).sum(0)

    def rows_of(self, indices: torch.Tensor) -> torch.Tensor:
        """Returns rows of the rollout, ordered by step."""
        if not self.options.lstm:
            return indices
        return self.rows.view(-1, self.options.num_envs)[:, indices].flatten()

    def loss(
        self, indices: torch.Tensor, mean: torch.Tensor, deviation: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Returns the loss and the metrics of minibatches, summed over a part of the rollout.

        `mean`, `deviation`: of the advantages of the minibatch.
        """
        rollout, clip = self.rollout, self.options.clip
        part = self.rows_of(indices)
        memory = first = None
        if self.options.lstm:
            memory = rollout.memory[:, indices]
            first = rollout.first.view(-1, self.options.num_envs)[:, indices]
        logits, values, _ = self.agent(rollout.observations[part], memory, first)
        advantages = (rollout.advantages[part] - mean) / deviation
        log_softmax = F.log_softmax(logits, -1)
        log_probabilities = log_softmax.gather(-1, rollout.actions[part, None]).squeeze(-1)
        log_ratio = log_probabilities - rollout.log_probabilities[part]
        ratio = log_ratio.exp()
        policy_loss = -torch.min(
            advantages * ratio, advantages * ratio.clamp(1 - clip, 1 + clip)
        ).sum()
        old_values, returns = rollout.values[part], rollout.returns[part]
        clipped_values = old_values + (values - old_values).clamp(-clip, clip)
        value_loss = torch.max((values - returns) ** 2, (clipped_values - returns) ** 2).sum() / 2
        entropy = -(log_softmax.exp() * log_softmax).sum()
        loss = policy_loss + self.options.value_coefficient * value_loss
        loss = loss - self.options.entropy_coefficient * entropy
        kl = (ratio - 1 - log_ratio).sum()  # Estimate, from old to new policy.
        clipped = ((ratio - 1).abs() > clip).sum()
        metrics = torch.stack([policy_loss, value_loss, entropy, kl, clipped])
        return loss / self.row_count_of_index, metrics.detach()

    def state(self) -> dict[str, Any]:
        """Returns the state that all ranks share, for a checkpoint."""
        return {"agent": self.agent.state_dict(), "optimizer": self.optimizer.state_dict()}

    def rank_state(self) -> dict[str, Any]:
        """Returns the state of this rank."""
        state = self.collector.state() | {"host_random": self.host_random.get_state()}
        if self.options.policy_lag:
            state["rollout"] = self.rollout  # There is one after each update.
        return state

    def restore(self, state: dict[str, Any], rank_state: dict[str, Any]) -> None:
        """Continues from a checkpoint."""
        self.agent.load_state_dict(state["agent"])
        self.optimizer.load_state_dict(state["optimizer"])
        self.host_random.set_state(rank_state["host_random"])
        self.collector.restore(rank_state)
        if self.options.policy_lag:
            self.has_rollout = True
            for mine, its in zip(self.rollout, rank_state["rollout"], strict=True):
                mine.copy_(its)


def parse(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """Returns the options; the defaults are the paper's."""
    parser = run_parser("ppo", __doc__)
    add = parser.add_argument_group("hyperparameters").add_argument
    add("--chunk-size", type=int, help="observations per pass; 0: all; default: 256, on a GPU 0")
    add("--test-interval", type=int, default=0, help="steps between tests on all levels; 0: none")
    add(
        "--adam",
        default="tensorflow",
        choices=KINDS,
        help="whose way to add epsilon; default: %(default)s",
    )
    add("--frame-stack", type=int, default=1, help="frames in an observation; default: 1")
    add("--lstm", action="store_true", help="an LSTM behind the encoder")
    add(
        "--policy-lag",
        type=int,
        default=0,
        choices=(0, 1),
        help="1: collect a rollout with the weights of one update ago, while learning; default: 0",
    )
    add("--num-steps", type=int, default=256, help="per rollout; default: %(default)s")
    add("--epochs", type=int, default=3, help="default: %(default)s")
    add("--minibatches", type=int, default=8, help="default: %(default)s")
    for name, value in {
        "--learning-rate": 5e-4,
        "--gamma": 0.999,
        "--reward-gamma": 0.99,
        "--gae-lambda": 0.95,
        "--clip": 0.2,
        "--entropy-coefficient": 0.01,
        "--value-coefficient": 0.5,
        "--max-grad-norm": 0.5,
    }.items():
        add(name, type=float, default=value, help="default: %(default)s")
    options = parsed(parser, arguments)
    if options.test_interval < 0:
        parser.error(f"--test-interval is {options.test_interval}; it is at least 0")
    if options.chunk_size is None:
        options.chunk_size = 0 if options.device.startswith("cuda") else 256
    return options


def train(options: argparse.Namespace) -> int:
    """Trains, and returns the exit status."""
    device = set_device(options)
    ranks = Ranks("nccl" if device.type == "cuda" else "gloo")
    its_options = environment_options(options, ranks.rank, ranks.count)
    environments = Environments(options.game, options.num_envs, **its_options)
    evaluation = None
    try:
        learner = Ppo(options, ranks, environments)
        if options.test_interval and ranks.rank == 0:
            evaluation = PeriodicEvaluation(options, learner.policy)
        return TrainingRun(options, learner, ranks, evaluation).train()
    finally:
        if evaluation is not None:
            evaluation.close()
        environments.close()
        ranks.close()


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line; returns the exit status, 1 after an error of the server."""
    try:
        return train(parse(arguments))
    except ProcgenError as error:
        print(f"learners.ppo: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
