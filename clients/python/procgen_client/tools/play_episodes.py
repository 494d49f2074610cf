"""Plays equally many episodes in each environment."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

from procgen_client.pool import Pool
from procgen_client.tools.episode_statistics import Episode, EpisodeStatistics

# From observations, uint8 [N, *F], to actions, int [N]. A recurrent policy has a second parameter
# `first`, bool [N]: the observation is the first of an episode.
Policy = Callable[..., Any]


def play_episodes(
    game: str,
    policy: Policy,
    *,
    env_count: int,
    episodes_per_env: int,
    progress: Callable[[int, int], None] = lambda *_: None,
    **options: Any,
) -> list[list[Episode]]:
    """Plays the same number of episodes in each environment.

    All of them count. The first episodes to end are short ones, with a biased mean return.

    Args:
        game: Name of the game.
        policy: Gets arrays of its own, which it may keep.
        env_count: Number of environments, N.
        episodes_per_env: Episodes per environment, k.
        progress: Called with the number of ended episodes and their total, N * k.
        **options: As for Pool.

    Returns:
        The episodes of each environment, in order: N lists of k.

    Raises:
        ProcgenError: As Pool and Pool.step.
    """
    played: list[list[Episode]] = [[] for _ in range(env_count)]
    total = env_count * episodes_per_env
    ended_count = 0
    is_recurrent = has_parameter(policy, "first")
    statistics = EpisodeStatistics(window=1)
    with Pool(game, env_count, **options) as pool:
        batch = pool.observe()
        progress(0, total)
        while ended_count < total:
            memory = {"first": batch.first} if is_recurrent else {}
            actions = policy(batch.observations, **memory)
            batch = pool.step(actions)
            before = ended_count
            for episode in statistics.add(batch):
                if len(played[episode.environment]) < episodes_per_env:
                    played[episode.environment].append(episode)
                    ended_count += 1
            if ended_count > before:
                progress(ended_count, total)
    return played


def has_parameter(function: Callable[..., Any], name: str) -> bool:
    """Returns whether a function has a parameter of this name; False: also if that is unknown."""
    try:
        return name in inspect.signature(function).parameters
    except (TypeError, ValueError):  # Written in C.
        return False
