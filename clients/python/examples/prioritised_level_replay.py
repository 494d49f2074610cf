#!/usr/bin/env python3
"""Prioritised level replay (Jiang et al., 2021) with a pool's level sampler.

Levels with a high learning potential are played more often. The learner scores each level when an
episode in it ends. At intervals the scores become the weights of a new sampler, which takes effect
as episodes end. A share of the draws goes to levels with stale scores.

The agent is random, and a level's score is the error of its expected return. Replace them by your
agent and its value loss (`act` and the call of `LevelReplay.add`).

    PYTHONPATH=clients/python clients/python/examples/prioritised_level_replay.py --steps 2000
"""

from __future__ import annotations

import argparse

import numpy as np

import procgen_client


class LevelReplay:
    """Scores of a fixed set of levels, and the level sampler computed from them.

    Attributes:
        level_seeds: int [n].
        expected_returns: float [n], running means.
        episode_counts: int [n].
    """

    def __init__(
        self, level_seeds: np.ndarray, *, temperature: float = 0.1, staleness: float = 0.1
    ) -> None:
        """Starts with no level played.

        Args:
            level_seeds: int [n], each once.
            temperature: A level of rank r has weight r ** (-1 / temperature). Lower values prefer
                the best levels more.
            staleness: Share of the draws weighted by the number of episodes since a level was
                played.
        """
        self.level_seeds = level_seeds
        self.expected_returns = np.zeros(len(level_seeds))
        self.episode_counts = np.zeros(len(level_seeds), np.int64)
        self._scores = np.full(len(level_seeds), np.inf)  # infinite until played
        self._last_played = np.zeros(len(level_seeds))
        self._episode_count = 0
        self._sampler_count = 0
        self._temperature = temperature
        self._staleness = staleness
        self._place_of = {int(seed): place for place, seed in enumerate(level_seeds)}

    def add(self, level_seed: int, episode_return: float) -> None:
        """Updates the score of a level whose episode has ended."""
        place = self._place_of[level_seed]
        error = episode_return - self.expected_returns[place]
        self._scores[place] = abs(error)
        self.expected_returns[place] += 0.5 * error
        self.episode_counts[place] += 1
        self._episode_count += 1
        self._last_played[place] = self._episode_count

    def sampler(self) -> procgen_client.LevelSampler:
        """Returns a sampler with weights of the current scores."""
        # Equal scores have equal ranks, e.g. all levels that were not played.
        ranks = 1 + np.searchsorted(np.sort(-self._scores), -self._scores)
        by_score = ranks.astype(float) ** (-1 / self._temperature)
        by_age = self._episode_count - self._last_played + 1
        weights = (1 - self._staleness) * by_score / by_score.sum()
        weights += self._staleness * by_age / by_age.sum()
        self._sampler_count += 1
        return procgen_client.LevelSampler(self.level_seeds, weights, self._sampler_count)


def act(observations: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Returns random actions, int [N]."""
    return random.integers(0, procgen_client.ACTION_COUNT, len(observations))


def train(
    pool: procgen_client.Pool, replay: LevelReplay, *, steps: int, steps_per_sampler: int
) -> None:
    """Steps the pool, scores levels and replaces the sampler; prints the progress."""
    random = np.random.default_rng(0)
    batch = pool.observe()
    for step in range(1, steps + 1):
        assert batch.observations is not None
        batch = pool.step(act(batch.observations, random))
        for i in np.flatnonzero(batch.ended):
            replay.add(int(batch.prev_level_seeds[i]), float(batch.episode_returns[i]))
        if step % steps_per_sampler == 0:
            pool.set_level_sampler(replay.sampler())
            played = np.count_nonzero(replay.episode_counts)
            print(
                f"step {step} of {steps}: {replay.episode_counts.sum()} episodes in {played} of "
                f"{len(replay.level_seeds)} levels",
                flush=True,
            )


def main() -> None:
    """Reads the arguments and plays."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--server", help="address; default: PROCGEN_SERVER, else in this process")
    parser.add_argument("--game", default="bigfish", help="default: %(default)s")
    parser.add_argument("--levels", type=int, default=200, help="number; default: %(default)s")
    parser.add_argument("--environments", type=int, default=64, help="default: %(default)s")
    parser.add_argument("--steps", type=int, default=5000, help="of each; default: %(default)s")
    parser.add_argument("--steps-per-sampler", type=int, default=500, help="default: %(default)s")
    arguments = parser.parse_args()
    replay = LevelReplay(np.arange(arguments.levels))
    with procgen_client.Pool(
        arguments.game,
        arguments.environments,
        server=arguments.server,
        distribution_mode="easy",
        level_sampler=replay.sampler(),
    ) as pool:
        train(
            pool, replay, steps=arguments.steps, steps_per_sampler=arguments.steps_per_sampler
        )
    most = np.argsort(-replay.episode_counts, kind="stable")[:5]
    for place in most:
        print(
            f"level {replay.level_seeds[place]}: {replay.episode_counts[place]} episodes, "
            f"expected return {replay.expected_returns[place]:.1f}"
        )


if __name__ == "__main__":
    main()
