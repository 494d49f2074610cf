"""The evaluation protocol of the benchmark's paper, and its scores."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from procgen_client._place import Server
from procgen_client._requests import ACTION_COUNT
from procgen_client.catalog import catalog
from procgen_client.errors import InvalidArgumentError
from procgen_client.options import GAMES
from procgen_client.tools.episode_statistics import Episode
from procgen_client.tools.play_episodes import Policy, play_episodes
from procgen_client.tools.score_statistics import (
    confidence_interval,
    interquartile_mean,
    resampled_means,
    standard_error,
)

MakePolicy = Callable[[str], Policy]  # From a game's name.

# Number of training levels in the paper, by mode.
TRAIN_LEVELS = {"easy": 200, "hard": 500}
# Options of a pool that a policy may need: the format of observations, the appearance.
POLICY_OPTIONS = (
    *("screen_size", "grayscale_obs", "layout", "frame_stack", "center_agent", "use_backgrounds"),
    *("use_generated_assets", "use_monochrome_assets", "restrict_themes", "paint_vel_info"),
)


class Protocol(NamedTuple):
    """Parameters of an evaluation."""

    mode: str = "hard"  # One of TRAIN_LEVELS.
    train_levels: int = 0  # Number of training levels, from 0 on; 0: TRAIN_LEVELS.
    episode_count: int = 100  # At least, per game and set of levels; equal per environment.
    env_count: int = 50  # Environments; at most episode_count.
    rand_seed: int = 0  # Seeds the choice of levels, and the bootstrap.
    options: Mapping[str, Any] = {}  # Values of POLICY_OPTIONS.


class LevelSetScore(NamedTuple):
    """Scores of a policy in a game, on a set of levels."""

    episodes: list[Episode]
    return_mean: float
    return_standard_error: float  # NaN: of one episode.
    score: float  # The mean return, normalised.
    score_interval: tuple[float, float]  # 95 % confidence.


class GameScore(NamedTuple):
    """Scores of a policy in a game."""

    game: str
    return_range: tuple[float, float]  # The returns that are normalised to 0 and 1.
    train: LevelSetScore  # On the training levels.
    test: LevelSetScore  # On all levels.


class Aggregate(NamedTuple):
    """Scores over all games, each with its 95 % confidence interval."""

    mean: float
    mean_interval: tuple[float, float]
    interquartile_mean: float
    interquartile_mean_interval: tuple[float, float]


class Evaluation(NamedTuple):
    """The results of an evaluation."""

    protocol: Protocol  # As played: with the number of training levels.
    games: list[GameScore]
    train: Aggregate
    test: Aggregate


def evaluate(
    games: Sequence[str],
    make_policy: MakePolicy,
    protocol: Protocol,
    progress: Callable[[str, str, int, int], None] = lambda *_: None,
    *,
    server: Server = None,
) -> Evaluation:
    """Plays each game on both sets of levels.

    Args:
        games: Names of games, at least one.
        make_policy: Returns a game's policy; called once for each set of levels.
        protocol: Parameters of the evaluation.
        progress: Called with the game, "train" or "test", the number of ended episodes and their
            total.
        server: As for Pool.

    Raises:
        InvalidArgumentError: A number of the protocol is out of range, an option is not one of
            POLICY_OPTIONS, or a game has no constants in that mode.
        ProcgenError: Any error of a pool.
    """
    protocol = _checked(protocol)
    ranges = {game: return_range(game, protocol.mode) for game in games}
    episodes: dict[str, list[list[Episode]]] = {"train": [], "test": []}
    for game in ranges:
        for levels, count in (("train", protocol.train_levels), ("test", 0)):
            episodes[levels].append(
                _play(
                    *(game, make_policy(game), protocol, count, server),
                    lambda *counts, game=game, levels=levels: progress(game, levels, *counts),
                )
            )
    train, train_aggregate = _scores(episodes["train"], ranges, protocol.rand_seed)
    test, test_aggregate = _scores(episodes["test"], ranges, protocol.rand_seed)
    scores = map(GameScore, ranges, ranges.values(), train, test)
    return Evaluation(protocol, list(scores), train_aggregate, test_aggregate)


def random_policy(game: str) -> Policy:
    """Returns a uniformly random policy."""
    random = np.random.default_rng(list(game.encode()))
    return lambda observations: random.integers(0, ACTION_COUNT, len(observations))


def return_range(game: str, mode: str) -> tuple[float, float]:
    """Returns the game's returns that are normalised to 0 and 1.

    Raises:
        InvalidArgumentError: There is no such game, or it has none in that mode.
    """
    for known in catalog()["games"]:
        of_mode = known["modes"].get(mode) if known["name"] == game else None
        if of_mode is not None and of_mode["return_range"] is not None:
            low, high = of_mode["return_range"]
            return low, high
    raise InvalidArgumentError(
        f"no constants for {game!r} in mode {mode}; games are {', '.join(GAMES)}"
    )


def _checked(protocol: Protocol) -> Protocol:
    """Validates the protocol; returns it with the number of training levels."""
    if protocol.mode not in TRAIN_LEVELS:
        raise InvalidArgumentError(
            f"mode is {protocol.mode!r}; it is one of {', '.join(TRAIN_LEVELS)}"
        )
    for name in ("episode_count", "env_count"):
        if getattr(protocol, name) < 1:
            raise InvalidArgumentError(f"{name} is {getattr(protocol, name)}; it is at least 1")
    if protocol.train_levels < 0:
        raise InvalidArgumentError(f"train_levels is {protocol.train_levels}; it is at least 0")
    for name in protocol.options:
        if name not in POLICY_OPTIONS:
            raise InvalidArgumentError(
                f"option is {name!r}; it is one of {', '.join(POLICY_OPTIONS)}"
            )
    return protocol._replace(train_levels=protocol.train_levels or TRAIN_LEVELS[protocol.mode])


def _play(
    game: str,
    policy: Policy,
    protocol: Protocol,
    num_levels: int,
    server: Server,
    progress: Callable[[int, int], None],
) -> list[Episode]:
    env_count = min(protocol.env_count, protocol.episode_count)
    played = play_episodes(
        *(game, policy),
        server=server,
        env_count=env_count,
        episodes_per_env=-(-protocol.episode_count // env_count),
        progress=progress,
        distribution_mode=protocol.mode,
        num_levels=num_levels,
        rand_seed=protocol.rand_seed,
        **protocol.options,
    )
    return [episode for of_environment in played for episode in of_environment]


def _scores(
    played: Sequence[list[Episode]], ranges: Mapping[str, tuple[float, float]], seed: int
) -> tuple[list[LevelSetScore], Aggregate]:
    """Returns the scores of each game, and those over all games."""
    returns = [np.array([each.episode_return for each in episodes]) for episodes in played]
    normalized = [
        (values - low) / (high - low)
        for values, (low, high) in zip(returns, ranges.values())
    ]
    resampled = resampled_means(normalized, seed)
    scores = [
        LevelSetScore(
            *(episodes, float(values.mean()), standard_error(values), float(score.mean())),
            confidence_interval(means),
        )
        for episodes, values, score, means in zip(
            played, returns, normalized, resampled.T
        )
    ]
    means = np.array([score.score for score in scores])
    aggregate = Aggregate(
        *(float(means.mean()), confidence_interval(resampled.mean(-1))),
        *(float(interquartile_mean(means)), confidence_interval(interquartile_mean(resampled))),
    )
    return scores, aggregate
