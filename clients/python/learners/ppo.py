"""PPO with the hyperparameters of the Procgen paper (Cobbe et al., 2020), on a Procgen Server.

    python3 -m learners.ppo --game coinrun --mode easy --levels 200 --output runs/coinrun
    torchrun --nproc_per_node 2 -m learners.ppo --game coinrun --output runs/coinrun

The environments are one pool in two halves: the server steps one half while the network processes
the other. The checkpoint has the complete state of a run, so a run that is stopped and continued
(--resume) equals an uninterrupted one; on a CPU, bit for bit.

T: steps in a rollout; N: environments of this process; B = T * N; F: the shape of an observation,
[64, 64, 3], or with a stack of k frames [k, 64, 64, 3].
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import nn
from torch.nn import functional as F  # noqa: N812 - the usual name

from learners.adam import KINDS, Adam
from learners.agent import MEMORY_SIZE, Agent, AgentPolicy, sampled
from learners.environments import Environments, Episode, environment_options, episodes_of
from learners.evaluation import PeriodicEvaluation
from learners.gradients import ChunkedGradients
from learners.networks import captured
from learners.options import parsed, run_parser, set_device
from learners.ranks import Ranks
from learners.training_run import TrainingRun, Update
from procgen_client import ACTION_COUNT, NormalizeReward
from procgen_client.errors import ProcgenError


class Rollout(NamedTuple):
    """T steps of N environments, flat: row t * N + i is step t of environment i."""

    observations: torch.Tensor  # uint8   [B, *F]
    actions: torch.Tensor  # int64   [B]
    log_probabilities: torch.Tensor  # Of the actions, at their choice   float32 [B]
    values: torch.Tensor  # Of the critic, at that time   float32 [B]
    advantages: torch.Tensor  # float32 [B]
    returns: torch.Tensor  # advantages + values   float32 [B]


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
        advantages[t] += decay[t] * advantages[t + 1]
    return advantages


class Ppo:
    """The algorithm of one rank: agent, optimiser, environments, random generators."""

    metric_names = (
        *("policy_loss", "value_loss", "entropy", "kl", "clip_fraction", "explained_variance"),
    )
    needs_checkpoint = False

    def __init__(
        self, options: argparse.Namespace, ranks: Ranks, environments: Environments
    ) -> None:
        """Starts with a new agent."""
        self.options, self.ranks, self.environments = options, ranks, environments
        self.device = torch.device(options.device)
        on_gpu = self.device.type == "cuda"
        torch.manual_seed(options.seed)
        self.agent = Agent(vars(options)).to(self.device)
        self.policy = AgentPolicy(self.agent)  # For tests during the training.
        self.parameters = list(self.agent.parameters())
        self.optimizer = Adam(self.parameters, options.learning_rate, options.adam)
        if on_gpu and options.compile:
            # Compiled twice: for the rows of a half and for those of a minibatch.
            (self.agent.encoder if options.lstm else self.agent).compile(dynamic=False)
        self.normalize = NormalizeReward(options.num_envs, gamma=options.reward_gamma)
        # The device's generator is for actions, the host's for minibatches.
        seed = options.seed + 1_000_003 * ranks.rank
        self.random = torch.Generator(self.device).manual_seed(seed)
        self.host_random = torch.Generator().manual_seed(seed)

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
        kept = (self.observations, self.actions, self.log_probabilities, self.values)
        self.rewards, self.ended, advantages, returns = torch.zeros(
            (4, shape[0] - 1, shape[1]), device=self.device
        )
        rollout = [*(tensor[:-1] for tensor in kept), advantages, returns]
        self.rollout = Rollout(*(tensor.flatten(0, 1) for tensor in rollout))
        # With a memory, minibatches consist of environments, each with all of its steps.
        self.row_count_of_index = options.num_steps if options.lstm else 1
        self.rows = torch.arange(len(self.rollout.actions), device=self.device)
        chunk_size = options.chunk_size and max(1, options.chunk_size // self.row_count_of_index)
        self.chunked = ChunkedGradients(
            self.parameters, chunk_size, 1 if on_gpu else options.threads
        )
        self.received = self.observations  # Where the client writes them.
        self.gradients, self.optimize = self.minibatch_gradients, self.step_on_minibatch
        self.fill_returns = self.estimate_on_device
        if on_gpu:
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
            if ranks.count == 1:
                self.optimize = captured(self.step_on_minibatch, self.optimizer.tensors())
            else:  # Averages of ranks are no part of a graph.
                self.gradients = captured(self.minibatch_gradients)
            self.prepare = captured(self.agent.encoder.prepare)

    def update(self) -> Update:
        """Collects a rollout and learns from it."""
        update = self.collect()._replace(metrics=self.learn())
        if self.device.type == "cuda":
            self.prepare()  # For tests; collect does not know the weights of a checkpoint.
        return update

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
        if self.device.type == "cuda":
            self.prepare()
        clock = time.perf_counter
        begin = clock()
        sending = _called(float)
        with ThreadPoolExecutor(1) as sender:
            submit = sender.submit if self.sends_in_background() else _called
            for t, rows, batch in self.environments.rollout(step_count, self.received):
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
        environments = self.environments
        in_process = environments.has_independent_halves and not environments.can_be_watched
        return self.device.type == "cuda" and in_process

    def send(self, choice: Callable[[], np.ndarray], t: int, rows: slice | None) -> float:
        """Sends actions, unless `rows` is None, when chosen; returns the seconds of sending."""
        actions = choice()
        begin = time.perf_counter()
        if rows is not None:
            self.environments.send(actions, rows, self.annotations(t, rows))
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
        if self.memories is None:
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
        memory = None if self.memories is None else self.memories[0][:, indices]
        first = None if self.memories is None else self.first[:-1, indices]
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
        return {
            "normalizer": self.normalize.state_dict(),
            "random": self.random.get_state(),
            "host_random": self.host_random.get_state(),
            "states": self.environments.save_states(),
            "first": self.first[-1],
            "memory": None if self.memories is None else self.memories[-2],
        }

    def restore(self, state: dict[str, Any], rank_state: dict[str, Any]) -> None:
        """Continues from a checkpoint."""
        self.agent.load_state_dict(state["agent"])
        self.optimizer.load_state_dict(state["optimizer"])
        self.normalize.load_state_dict(rank_state["normalizer"])
        self.random.set_state(rank_state["random"])
        self.host_random.set_state(rank_state["host_random"])
        self.environments.restore_states(rank_state["states"])
        self.first[-1] = rank_state["first"]
        if self.memories is not None:
            self.memories[-2] = rank_state["memory"]


def _called(function: Callable[..., float], *arguments: Any) -> Future[float]:  # noqa: ANN401
    """Calls a function; returns the result as ThreadPoolExecutor.submit does."""
    future: Future[float] = Future()
    future.set_result(function(*arguments))
    return future


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


def train(
    options: argparse.Namespace, make_environments: Callable[..., Any] = Environments
) -> int:
    """Trains, and returns the exit status. learners.upstream passes `make_environments`."""
    device = set_device(options)
    ranks = Ranks("nccl" if device.type == "cuda" else "gloo")
    its_options = environment_options(options, ranks.rank, ranks.count)
    environments = make_environments(options.game, options.num_envs, **its_options)
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
