"""PPO on upstream's package, for comparison with a run on this engine.

    python3 -m learners.upstream --game coinrun --seed 1 --output runs/upstream
    PROCGEN_ART=procgen python3 -m learners.ppo --game coinrun --seed 1 --output runs/here
    python3 -m learners.compare_runs runs/here runs/upstream

Needs `pip install procgen` (Procgen 0.10.7). The other run needs upstream's art, since the policy
acts on pixels. The options are those of learners.ppo. Runs cannot be continued.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import torch

from learners import ppo


class Step(NamedTuple):
    """The fields of a Batch that a learner reads, for a half of the environments."""

    observations: np.ndarray
    rewards: np.ndarray
    ended: np.ndarray
    prev_level_seeds: np.ndarray
    episode_returns: np.ndarray
    episode_lengths: np.ndarray


class UpstreamEnvironments:
    """The interface of learners.environments.Environments over a ProcgenGym3Env.

    It steps all environments together, after the actions of both halves.
    """

    has_independent_halves = False
    can_be_watched = False

    def __init__(
        self,
        game: str,
        env_count: int,
        *,
        package: str,
        server: str | None,
        server_timeout: float,
        watch: str | None,
        first_env: int,
        total_env_count: int,
        **options: Any,  # noqa: ANN401
    ) -> None:
        """Creates the environments; addresses and ranks are not supported."""
        if server or watch or total_env_count != env_count:
            raise SystemExit("upstream's package supports no --server, --watch or several ranks")
        middle = env_count // 2
        self.halves = (slice(0, middle), slice(middle, env_count))
        make = importlib.import_module(package).ProcgenGym3Env
        self._env = make(num=env_count, env_name=game, **options)
        self._actions = np.zeros(env_count, np.int32)
        self._returns = np.zeros(env_count, np.float32)
        self._lengths = np.zeros(env_count, np.int32)

    def rollout(
        self, step_count: int, out: torch.Tensor
    ) -> Iterator[tuple[int, slice, Step]]:
        """Yields (t, rows, step) of each half; as DoubleBufferedSampler.rollout."""
        for t in range(step_count + 1):
            if t > 0:
                self._env.act(self._actions)
                self._returns += self._env.observe()[0]
                self._lengths += 1
            for rows, step in zip(self.halves, self._state(), strict=True):
                np.copyto(np.asarray(out)[(t, rows) if out.ndim == 5 else rows], step.observations)
                yield t, rows, step

    def send(
        self, actions: np.ndarray, rows: slice, annotations: Mapping[str, np.ndarray]
    ) -> None:
        """Takes the actions of a half; nobody sees the annotations."""
        self._actions[rows] = actions

    def save_states(self) -> list[bytes]:
        """Returns an empty list: a run cannot be continued."""
        return []

    def restore_states(self, states: list[bytes]) -> None:
        """Refuses to continue a run."""
        raise SystemExit("a run on upstream's package cannot be continued")

    def close(self) -> None:
        """Closes the environments."""
        self._env.close()

    def _state(self) -> list[Step]:
        rewards, observations, first = self._env.observe()
        prev_levels = np.array([info["prev_level_seed"] for info in self._env.get_info()])
        ended = first.astype(bool)
        steps = [
            Step(
                *(observations["rgb"][rows].copy(), rewards[rows].copy(), ended[rows]),
                *(prev_levels[rows], self._returns[rows].copy(), self._lengths[rows].copy()),
            )
            for rows in self.halves
        ]
        self._returns[ended] = 0
        self._lengths[ended] = 0
        return steps


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line; returns the exit status."""
    parser = argparse.ArgumentParser(
        prog="python3 -m learners.upstream",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Other options are those of learners.ppo.",
    )
    parser.add_argument("--package", default="procgen", help="default: %(default)s")
    given, others = parser.parse_known_args(arguments)

    def make(*positional: Any, **keywords: Any) -> UpstreamEnvironments:  # noqa: ANN401
        return UpstreamEnvironments(*positional, package=given.package, **keywords)

    return ppo.train(ppo.parse(others), make)


if __name__ == "__main__":
    sys.exit(main())
