"""procgen-evaluate: scores a policy on its training levels and on all levels.

The protocol of the benchmark's paper (Cobbe et al., 2020): a policy is trained on a fixed set of
levels (200 easy or 500 hard ones, from level 0 on) and evaluated on these and on all levels.
Returns are normalised by each game's constants in the server's catalog,
(return - min) / (max - min), and averaged over games.

    procgen-evaluate --policy my_package.my_module:make_policy --plot returns.png

`make_policy(game)` returns the game's policy: a function from observations, uint8 [N, 64, 64, 3],
to actions, int [N]. The default is a random policy.

Each environment plays the same number of episodes, and all of them count. The first episodes to end
are short ones, with a biased mean return.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np

from procgen_client._proto import catalog_pb2, pools_pb2
from procgen_client._requests import ACTION_COUNT
from procgen_client.client import Client
from procgen_client.errors import InvalidArgumentError, ProcgenError
from procgen_client.options import GAMES
from procgen_client.tools.local_server import is_local, open_client

Policy = Callable[[np.ndarray], Any]  # Observations uint8 [N, 64, 64, 3] -> actions int [N].
MakePolicy = Callable[[str], Policy]  # From a game's name.

# Number of training levels in the paper, by mode.
TRAIN_LEVELS = {"easy": 200, "hard": 500}


class Protocol(NamedTuple):
    """Parameters of an evaluation."""

    mode: str = "hard"  # One of TRAIN_LEVELS.
    train_levels: int = 0  # Number of training levels, from 0 on; 0: TRAIN_LEVELS.
    episode_count: int = 100  # At least, per game and set of levels; equal per environment.
    env_count: int = 50  # Environments; at most episode_count.
    rand_seed: int = 0  # Seeds the choice of levels.


class GameScore(NamedTuple):
    """Scores of a policy in a game."""

    game: str
    episode_count: int  # Per set of levels.
    train_return: float  # Mean return on the training levels.
    test_return: float  # Mean return on all levels.
    train_score: float  # The returns, normalised.
    test_score: float


def evaluate(
    client: Client,
    games: Sequence[str],
    make_policy: MakePolicy,
    protocol: Protocol,
    progress: Callable[[str, str, int, int], None] = lambda *_: None,
) -> list[GameScore]:
    """Plays each game on both sets of levels.

    Args:
        client: Connection to the server.
        games: Names of games.
        make_policy: Returns a game's policy; called once for each set of levels.
        protocol: Parameters of the evaluation.
        progress: Called with the game, "train" or "test", the number of ended episodes and their
            total.

    Raises:
        InvalidArgumentError: A number of the protocol is out of range, or a game has no constants
            in that mode.
        ProcgenError: Any error of the server.
    """
    train_levels = _check(protocol)
    scores = []
    for game in games:
        low, high = return_range(client.catalog(), game, protocol.mode)
        returns: dict[str, np.ndarray] = {}
        for levels, count in (("train", train_levels), ("test", 0)):
            policy = make_policy(game)
            returns[levels] = _play(
                client, game, policy, protocol, count, lambda *told: progress(game, levels, *told)
            )
        train, test = (float(returns[levels].mean()) for levels in ("train", "test"))
        scores.append(
            GameScore(
                game,
                returns["test"].size,
                train,
                test,
                (train - low) / (high - low),
                (test - low) / (high - low),
            )
        )
    return scores


def random_policy(game: str) -> Policy:
    """Returns a uniformly random policy."""
    random = np.random.default_rng(list(game.encode()))
    return lambda observations: random.integers(0, ACTION_COUNT, len(observations))


def _check(protocol: Protocol) -> int:
    """Validates `protocol`, and returns the number of training levels."""
    if protocol.mode not in TRAIN_LEVELS:
        raise InvalidArgumentError(
            f"mode is {protocol.mode!r}; it is one of {', '.join(TRAIN_LEVELS)}"
        )
    for name in ("episode_count", "env_count"):
        if getattr(protocol, name) < 1:
            raise InvalidArgumentError(f"{name} is {getattr(protocol, name)}; it is at least 1")
    if protocol.train_levels < 0:
        raise InvalidArgumentError(f"train_levels is {protocol.train_levels}; it is at least 0")
    return protocol.train_levels or TRAIN_LEVELS[protocol.mode]


def return_range(catalog: catalog_pb2.Catalog, game: str, mode: str) -> tuple[float, float]:
    """Returns the game's returns that are normalised to 0 and 1.

    Raises:
        InvalidArgumentError: There is no such game, or it has none in that mode.
    """
    number = pools_pb2.DistributionMode.Value(f"DISTRIBUTION_MODE_{mode.upper()}")
    for its_mode in (each for known in catalog.games if known.name == game for each in known.modes):
        if its_mode.distribution_mode == number and its_mode.HasField("return_range"):
            return its_mode.return_range.min, its_mode.return_range.max
    raise InvalidArgumentError(
        f"no constants for {game!r} in mode {mode}; games are {', '.join(GAMES)}"
    )


def _play(
    client: Client,
    game: str,
    policy: Policy,
    protocol: Protocol,
    num_levels: int,
    progress: Callable[[int, int], None],
) -> np.ndarray:
    """Plays k episodes in each environment and returns their returns, [N, k]."""
    env_count = min(protocol.env_count, protocol.episode_count)
    each = -(-protocol.episode_count // env_count)
    returns = np.zeros((env_count, each), np.float32)
    played = np.zeros(env_count, np.int64)
    with client.create_pool(
        game,
        env_count,
        distribution_mode=protocol.mode,
        num_levels=num_levels,
        rand_seed=protocol.rand_seed,
        transport="shared_memory" if is_local(client) else "stream",
    ) as pool:
        batch = pool.observe()
        progress(0, returns.size)
        while (played < each).any():
            assert batch.observations is not None
            batch = pool.step(policy(batch.observations))
            ended = np.flatnonzero(batch.ended & (played < each))
            if len(ended):
                returns[ended, played[ended]] = batch.episode_returns[ended]
                played[ended] += 1
                progress(int(played.sum()), returns.size)
    return returns


def table(scores: Sequence[GameScore]) -> str:
    """Returns the scores as a Markdown table, with the mean normalised returns last."""
    lines = [
        "| game | train levels | all levels | normalised: train | all | gap |",
        "| --- | ---: | ---: | ---: | ---: | ---: |",
    ]
    lines += [
        f"| {score.game} | {score.train_return:.2f} | {score.test_return:.2f} | "
        f"{score.train_score:.3f} | {score.test_score:.3f} | "
        f"{score.train_score - score.test_score:.3f} |"
        for score in scores
    ]
    train, test = means(scores)
    lines.append(f"| mean | | | {train:.3f} | {test:.3f} | {train - test:.3f} |")
    return "\n".join(lines)


def means(scores: Sequence[GameScore]) -> tuple[float, float]:
    """Returns the mean normalised returns on the training levels and on all levels."""
    return (
        float(np.mean([score.train_score for score in scores])),
        float(np.mean([score.test_score for score in scores])),
    )


def plot(scores: Sequence[GameScore], path: str) -> None:
    """Draws the normalised returns as bars; needs matplotlib."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(max(4.0, 1.0 + 0.6 * len(scores)), 4.0), layout="constrained")
    axes = figure.subplots()
    places = np.arange(len(scores))
    bars = {"train levels": "train_score", "all levels": "test_score"}
    for shift, (label, field) in zip((-0.2, 0.2), bars.items(), strict=True):
        axes.bar(places + shift, [getattr(score, field) for score in scores], 0.4, label=label)
    axes.set_xticks(places, [score.game for score in scores], rotation=45, ha="right")
    axes.set_ylabel("normalised return")
    axes.axhline(0, color="black", linewidth=0.8)
    axes.legend()
    figure.savefig(path)


class ProgressLine:
    """Prints progress: on a terminal one line that is overwritten, otherwise a line per game."""

    def __init__(self, stream: IO[str], game_count: int) -> None:
        """Takes the output stream and the number of games."""
        self._stream = stream
        self._game_count = game_count
        self._begun: list[str] = []

    def __call__(self, game: str, levels: str, ended: int, count: int) -> None:
        """Prints the progress."""
        if game not in self._begun:
            self._begun.append(game)
        where = f"[{len(self._begun)}/{self._game_count}] {game}, {levels} levels"
        line = f"{where}: {ended} of {count} episodes"
        if self._stream.isatty():
            self._stream.write(f"\r\033[K{line}" + ("\n" if ended == count else ""))
        elif ended == count:
            self._stream.write(line + "\n")
        self._stream.flush()


def load_policy(name: str) -> MakePolicy:
    """Returns the function that "MODULE:FUNCTION" names.

    Raises:
        InvalidArgumentError: The name has another form, or there is no such function.
    """
    module, separator, function = name.partition(":")
    if not separator:
        raise InvalidArgumentError(f"policy is {name!r}; it is MODULE:FUNCTION")
    sys.path.insert(0, "")  # As python3 -m: find modules of the working folder.
    try:
        make_policy: Callable[[str], Policy] = getattr(importlib.import_module(module), function)
        return make_policy
    except (ImportError, AttributeError) as error:
        raise InvalidArgumentError(f"policy is {name!r}: {error}") from error


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line; returns the exit status, 2 after an error."""
    parser = _parser()
    given = parser.parse_args(arguments)
    games = list(GAMES) if given.games == ["all"] else given.games
    protocol = Protocol(
        given.mode, given.train_levels, given.episodes, given.environments, given.seed
    )
    if given.plot and importlib.util.find_spec("matplotlib") is None:
        parser.error("--plot needs matplotlib, which is not installed")
    client = None
    try:
        make_policy = load_policy(given.policy) if given.policy else random_policy
        client = open_client(given.server)
        told = ProgressLine(sys.stderr, len(games))
        scores = evaluate(client, games, make_policy, protocol, told)
    except ProcgenError as error:
        print(f"procgen-evaluate: {error}", file=sys.stderr)
        return 2
    finally:
        if client is not None:
            client.close()
    print(table(scores))
    if given.json:
        train, test = means(scores)
        results = {
            "protocol": protocol._asdict(),
            "games": [score._asdict() for score in scores],
            "mean_train_score": train,
            "mean_test_score": test,
        }
        Path(given.json).write_text(json.dumps(results, indent=2) + "\n")
    if given.plot:
        plot(scores, given.plot)
    return 0


def _parser() -> argparse.ArgumentParser:
    default = Protocol()
    parser = argparse.ArgumentParser(
        prog="procgen-evaluate",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("games", nargs="*", default=["all"], help="games; default: all sixteen")
    parser.add_argument("--policy", metavar="MODULE:FUNCTION", help="default: a random policy")
    parser.add_argument("--server", help="address; default: PROCGEN_SERVER, else a local server")
    parser.add_argument("--mode", default=default.mode, help="easy or hard; default: %(default)s")
    parser.add_argument(
        "--train-levels", type=int, default=0, help="from 0 on; default: 200 easy, 500 hard"
    )
    parser.add_argument(
        "--episodes", type=int, default=default.episode_count, help="default: %(default)s"
    )
    parser.add_argument(
        "--environments", type=int, default=default.env_count, help="default: %(default)s"
    )
    parser.add_argument("--seed", type=int, default=0, help="of levels; default: %(default)s")
    parser.add_argument("--plot", metavar="FILE", help="draw the normalised returns")
    parser.add_argument("--json", metavar="FILE", help="write all results")
    return parser


if __name__ == "__main__":
    sys.exit(main())
