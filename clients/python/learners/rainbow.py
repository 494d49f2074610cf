"""Rainbow (Hessel et al., 2018) on a Procgen Server.

    python3 -m learners.rainbow --game bigfish --mode easy --levels 200 --output runs/bigfish

A double, duelling, distributional DQN (51 atoms over the game's range of returns) with n-step
returns, noisy layers and prioritised replay. As in ppo.py the environments are one pool in two
halves; the server steps them while the network learns. The replay is a file in DIR beside the
checkpoint. A run that is stopped and continued equals an uninterrupted one.

N: environments; B: transitions of a minibatch; A: actions; Z: atoms.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import nn
from torch.nn import functional as F  # noqa: N812 - the usual name

from learners.environments import Environments, Episode, environment_options, episodes_of
from learners.gradients import ChunkedGradients
from learners.networks import DENSE_SIZES, captured, make_encoder
from learners.options import parsed, run_parser, set_device
from learners.ranks import Ranks
from learners.replay import Replay
from learners.run_folder import CHECKPOINT
from learners.training_run import TrainingRun, Update
from procgen_client import ACTION_COUNT
from procgen_client.errors import ProcgenError

REPLAY = "replay.bin"  # In the folder of a run.
VALUE_MIN = {"fruitbot": -5.0}  # Of other games 0; as in the paper.


class NoisyLinear(nn.Module):
    """A linear layer with noisy weights, of learnt scale (Fortunato et al.)."""

    def __init__(self, in_count: int, out_count: int, sigma: float = 0.5) -> None:
        """Starts without noise; :meth:`resample` draws it."""
        super().__init__()
        bound = in_count**-0.5
        self.weight = nn.Parameter(torch.empty(out_count, in_count).uniform_(-bound, bound))
        self.bias = nn.Parameter(torch.empty(out_count).uniform_(-bound, bound))
        self.weight_sigma = nn.Parameter(torch.full((out_count, in_count), sigma * bound))
        self.bias_sigma = nn.Parameter(torch.full((out_count,), sigma * bound))
        self.register_buffer("in_noise", torch.zeros(in_count))
        self.register_buffer("out_noise", torch.zeros(out_count))

    def resample(self, random: torch.Generator) -> None:
        """Draws factorised noise."""
        for noise in (self.in_noise, self.out_noise):
            noise.normal_(generator=random)
            noise.copy_(noise.sign() * noise.abs().sqrt())

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Returns [n, out_count] of x [n, in_count]."""
        weight = self.weight + self.weight_sigma * torch.outer(self.out_noise, self.in_noise)
        return F.linear(x, weight, self.bias + self.bias_sigma * self.out_noise)


class QNetwork(nn.Module):
    """Distributions of returns for each action; all linear layers are noisy (Hessel et al.)."""

    def __init__(self, options: Mapping[str, Any]) -> None:
        """Makes the network that the options of a run describe."""
        super().__init__()
        network = options["network"]
        self.encoder = make_encoder(
            *(network, options["width"], getattr(torch, options["precision"]), options["init"]),
            dense=False,
        )
        atom_count, hidden_count = options["atoms"], DENSE_SIZES[network]

        def stream(out_count: int) -> nn.Sequential:
            hidden = NoisyLinear(self.encoder.feature_count, hidden_count)
            return nn.Sequential(hidden, nn.ReLU(), NoisyLinear(hidden_count, out_count))

        self.value, self.advantage = stream(atom_count), stream(ACTION_COUNT * atom_count)
        atoms = torch.linspace(options["value_min"], options["value_max"], atom_count)
        self.register_buffer("atoms", atoms)

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Returns log-probabilities of atoms, [n, A, Z], of observations, uint8 [n, 64, 64, 3]."""
        features = self.encoder(observations)
        advantage = self.advantage(features).view(len(features), ACTION_COUNT, -1)
        value = self.value(features)[:, None]
        return F.log_softmax(value + advantage - advantage.mean(1, keepdim=True), -1)

    def best(self, observations: torch.Tensor) -> torch.Tensor:
        """Returns the actions with the largest mean returns, [n]."""
        return (self(observations).exp() @ self.atoms).argmax(-1)

    def resample(self, random: torch.Generator) -> None:
        """Draws new noise."""
        for layer in self.noisy_layers():
            layer.resample(random)

    def noisy_layers(self) -> list[NoisyLinear]:
        """Returns the layers with noise."""
        return [layer for layer in self.modules() if isinstance(layer, NoisyLinear)]


def project(
    probabilities: torch.Tensor, atoms: torch.Tensor, returns: torch.Tensor, discounts: torch.Tensor
) -> torch.Tensor:
    """Returns the distribution of `returns + discounts * z` on the atoms (Bellemare et al.).

    Args:
        probabilities: Of the atoms, [B, Z].
        atoms: Evenly spaced, [Z].
        returns: [B].
        discounts: [B].
    """
    low, high = atoms[0], atoms[-1]
    position = (returns[:, None] + discounts[:, None] * atoms).clamp(low, high)
    position = (position - low) / (high - low) * (len(atoms) - 1)
    lower = position.floor().clamp(0, len(atoms) - 2)
    to_upper = position - lower
    index = lower.long()
    projected = torch.zeros_like(probabilities)
    projected.scatter_add_(1, index, probabilities * (1 - to_upper))
    return projected.scatter_add_(1, index + 1, probabilities * to_upper)


class Rainbow:
    """The algorithm: networks, optimiser, replay, environments, random generators."""

    metric_names = ("loss", "q_mean")

    def __init__(
        self, options: argparse.Namespace, environments: Environments, replay: Replay
    ) -> None:
        """Starts with a new network."""
        self.options, self.environments, self.replay = options, environments, replay
        self.device = torch.device(options.device)
        on_gpu = self.device.type == "cuda"
        torch.manual_seed(options.seed)
        self.online, self.target = (QNetwork(vars(options)).to(self.device) for _ in range(2))
        self.target.load_state_dict(self.online.state_dict())
        self.parameters = list(self.online.parameters())
        self.optimizer = torch.optim.Adam(
            self.parameters, options.learning_rate, eps=1.5e-4, fused=on_gpu
        )
        self.evaluate: Callable[..., Any] = self.online
        if on_gpu and options.compile:
            self.evaluate = torch.compile(self.online)
        self.gradients = ChunkedGradients(
            self.parameters, options.chunk_size, 1 if on_gpu else options.threads
        )
        self.random = torch.Generator(self.device).manual_seed(options.seed)
        self.host_random = np.random.default_rng(options.seed)
        self.saved_row_count = 0  # Rows of the replay at the last checkpoint.
        self.received = torch.zeros((options.num_envs, 64, 64, 3), dtype=torch.uint8)
        if on_gpu:
            self.received = self.received.pin_memory()
        best = torch.no_grad()(self.online.best)
        self.best = captured(best) if on_gpu else best

    @property
    def needs_checkpoint(self) -> bool:
        """Whether the next update would overwrite rows of the last checkpoint."""
        added = self.replay.row_count - self.saved_row_count
        return added + self.options.num_steps > self.replay.slack

    def update(self) -> Update:
        """Takes num_steps steps of each environment, and learns after each."""
        episodes: list[Episode] = []
        metrics: list[torch.Tensor] = []
        seconds = np.zeros(2)
        self.collect(episodes, metrics, seconds)
        means = torch.stack(metrics).mean(0).tolist() if metrics else ["", ""]
        return Update(self.options.num_steps, episodes, *seconds.tolist(), means)

    def collect(
        self, episodes: list[Episode], metrics: list[torch.Tensor], seconds: np.ndarray
    ) -> None:
        """Takes the steps; the server steps both halves while the network learns.

        Args:
            episodes: Ended episodes are appended.
            metrics: metric_names of each minibatch are appended.
            seconds: Time of waiting for environments and of choosing actions is added, [2].
        """
        step_count = self.options.num_steps
        clock = time.perf_counter
        begin = clock()
        for t, rows, batch in self.environments.rollout(step_count, out=self.received):
            received = clock()
            seconds[0] += received - begin
            if t > 0:
                self.replay.set_outcome(rows, batch.rewards, batch.ended)
                episodes += episodes_of(batch, t, rows.start)
            if t < step_count:
                actions = self.choose(rows)
                decided = clock()
                self.replay.add(rows, self.received[rows].numpy(), actions)
                self.environments.send(actions)
                seconds[1] += decided - received
                if rows == self.environments.halves[-1]:
                    self.replay.finish()
                    steps = self.replay.row_count * self.options.num_envs
                    if steps >= self.options.learning_starts:
                        metrics.append(self.learn())
            begin = clock()

    def choose(self, rows: slice) -> np.ndarray:
        """Returns the best actions with new noise; random ones before learning starts."""
        if self.replay.row_count * self.options.num_envs < self.options.learning_starts:
            return self.host_random.integers(0, ACTION_COUNT, rows.stop - rows.start)
        self.online.resample(self.random)
        return self.best(self.received[rows].to(self.device)).cpu().numpy()

    def learn(self) -> torch.Tensor:
        """Takes an optimiser step; returns means of metric_names."""
        options = self.options
        step = self.replay.row_count * options.num_envs
        share = min(1.0, step / options.total_steps)
        beta = options.beta + (1 - options.beta) * share
        sample = self.replay.sample(options.batch_size, beta, self.host_random)
        self.online.resample(self.random)
        self.target.resample(self.random)
        tensors = [torch.from_numpy(array).to(self.device) for array in sample[1:]]
        gradients, results = self.gradients(self.loss, *tensors)
        for parameter, gradient in zip(self.parameters, gradients, strict=True):
            parameter.grad = gradient
        nn.utils.clip_grad_norm_(self.parameters, options.max_grad_norm)
        self.optimizer.step()
        losses, q_values = torch.cat(results, 1)
        self.replay.set_priorities(sample.indices, losses.cpu().numpy())
        if self.replay.row_count % max(1, options.target_interval // options.num_envs) == 0:
            self.target.load_state_dict(self.online.state_dict())
        return torch.stack([losses.mean(), q_values.mean()])

    def loss(self, *tensors: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Returns the summed weighted loss, and losses and values of each transition, [2, B]."""
        observations, actions, returns, discounts, next_observations, weights = tensors
        with torch.no_grad():
            chosen = self.online.best(next_observations)
            rows = torch.arange(len(chosen), device=self.device)
            next_probabilities = self.target(next_observations)[rows, chosen].exp()
            targets = project(next_probabilities, self.online.atoms, returns, discounts)
        predicted = self.evaluate(observations)[rows, actions]
        losses = -(targets * predicted).sum(-1)
        values = predicted.detach().exp() @ self.online.atoms
        return (weights * losses).sum(), torch.stack([losses.detach(), values])

    def state(self) -> dict[str, Any]:
        """Returns the networks and the optimiser, for a checkpoint."""
        return {
            "online": self.online.state_dict(),
            "target": self.target.state_dict(),
            "optimizer": self.optimizer.state_dict(),
        }

    def rank_state(self) -> dict[str, Any]:
        """Returns all other state; writes the observations of the replay to disk."""
        self.saved_row_count = self.replay.row_count
        return {
            "replay": self.replay.state(),
            "random": self.random.get_state(),
            "host_random": self.host_random.bit_generator.state,
            "states": self.environments.pool.save_states(),
        }

    def restore(self, state: dict[str, Any], rank_state: dict[str, Any]) -> None:
        """Continues from a checkpoint."""
        self.online.load_state_dict(state["online"])
        self.target.load_state_dict(state["target"])
        self.optimizer.load_state_dict(state["optimizer"])
        self.replay.restore(rank_state["replay"])
        self.saved_row_count = self.replay.row_count
        self.random.set_state(rank_state["random"])
        self.host_random.bit_generator.state = rank_state["host_random"]
        self.environments.pool.restore_states(rank_state["states"])


def load_policy(
    options: dict[str, Any], state: dict[str, Any]
) -> Callable[[np.ndarray], np.ndarray]:
    """Returns the policy of a run: the best actions, without noise."""
    network = QNetwork(options)
    network.load_state_dict(state["online"])
    for layer in network.noisy_layers():
        layer.in_noise.zero_()
        layer.out_noise.zero_()

    @torch.no_grad()
    def act(observations: np.ndarray) -> np.ndarray:
        return network.best(torch.from_numpy(observations)).numpy()

    return act


def parse(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """Returns the options."""
    parser = run_parser("rainbow", __doc__)
    # The paper's eight workers of 64 environments average the gradients of 512 transitions each.
    parser.set_defaults(num_envs=512)
    add = parser.add_argument_group("hyperparameters").add_argument
    add("--num-steps", type=int, default=32, help="steps per update; default: %(default)s")
    add("--chunk-size", type=int, help="transitions per pass; 0: all; default: 128, on a GPU 0")
    add("--replay-size", type=int, default=1_000_000, help="observations; default: %(default)s")
    add("--learning-starts", type=int, default=20_000, help="in steps; default: %(default)s")
    add("--batch-size", type=int, default=4096, help="of a minibatch; default: %(default)s")
    add("--n", type=int, default=3, help="steps of a transition; default: %(default)s")
    add("--atoms", type=int, default=51, help="default: %(default)s")
    add("--value-min", type=float, help="default: 0; of fruitbot -5")
    add("--value-max", type=float, help="default: the game's highest return")
    add("--target-interval", type=int, default=8192, help="in steps; default: %(default)s")
    for name, value in {
        "--learning-rate": 2.5e-4,
        "--gamma": 0.99,
        "--alpha": 0.5,
        "--beta": 0.4,
        "--max-grad-norm": 10.0,
    }.items():
        add(name, type=float, default=value, help="default: %(default)s")
    options = parsed(parser, arguments)
    if options.chunk_size is None:
        options.chunk_size = 0 if options.device.startswith("cuda") else 128
    return options


def train(options: argparse.Namespace) -> int:
    """Trains; returns the exit status."""
    device = set_device(options)
    ranks = Ranks("nccl" if device.type == "cuda" else "gloo")
    if ranks.count > 1:
        raise SystemExit("Rainbow has one rank: only one process can use its replay")
    folder = Path(options.output)
    if (folder / CHECKPOINT).exists() and not (folder / REPLAY).exists():
        raise SystemExit(f"{folder / REPLAY} is missing: the run cannot be continued without it")
    its_options = environment_options(options, 0, 1)
    environments = Environments(options.game, options.num_envs, **its_options)
    try:
        if options.value_min is None:
            options.value_min = VALUE_MIN.get(options.game, 0.0)
        if options.value_max is None:
            options.value_max = environments.return_range(options.mode)[1]
        replay = Replay(
            folder / REPLAY,
            options.replay_size,
            options.num_envs,
            slack_min=options.num_steps,
            n=options.n,
            gamma=options.gamma,
            alpha=options.alpha,
        )
        return TrainingRun(options, Rainbow(options, environments, replay), ranks).train()
    finally:
        environments.close()


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line; returns the exit status, 1 after an error of the server."""
    try:
        return train(parse(arguments))
    except ProcgenError as error:
        print(f"learners.rainbow: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
