"""procgen-evaluate: scores a policy on its training levels and on all levels.

The protocol of the benchmark's paper (Cobbe et al., 2020): a policy is trained on a fixed set of
levels (200 easy or 500 hard ones, from level 0 on) and evaluated on these and on all levels.

    procgen-evaluate --policy my_package.my_module:make_policy --plot returns.png

`make_policy(game)` returns the game's policy: a function from observations, uint8 [N, 64, 64, 3],
to actions, int [N]. A recurrent policy has a second parameter named `first`, bool [N]: an episode
begins. The default is a random policy. --option sets what else a policy was trained with, such as
--option frame_stack=4.

Each environment plays the same number of episodes, and all of them count. The first episodes to end
are short ones, with a biased mean return.

Returns are printed with standard errors. A score is the mean return normalised by the game's
constants in the catalog, (return - min) / (max - min), and has a 95 % confidence interval:
rliable's stratified bootstrap over the episodes of each game. "mean" and "interquartile mean" are
those of the games' scores. The intervals do not contain the variation between training runs.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from procgen_client.errors import InvalidArgumentError, ProcgenError
from procgen_client.options import GAMES
from procgen_client.tools import score_report
from procgen_client.tools.evaluation import (
    POLICY_OPTIONS,
    MakePolicy,
    Protocol,
    evaluate,
    random_policy,
)
from procgen_client.tools.progress import ProgressLine


def print_progress() -> Callable[[str, str, int, int], None]:
    """Returns what prints the progress of an evaluation."""
    lines: dict[str, ProgressLine] = {}

    def show(game: str, levels: str, ended: int, count: int) -> None:
        name = f"{game}, {levels} levels:"
        lines.setdefault(name, ProgressLine(name, count, unit="episodes")).show(ended)

    return show


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
        make_policy: MakePolicy = getattr(importlib.import_module(module), function)
        return make_policy
    except (ImportError, AttributeError) as error:
        raise InvalidArgumentError(f"policy is {name!r}: {error}") from error


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line; returns the exit status, 2 after an error."""
    parser = _parser()
    given = parser.parse_args(arguments)
    games = list(GAMES) if given.games == ["all"] else given.games
    if given.plot and importlib.util.find_spec("matplotlib") is None:
        parser.error("--plot needs matplotlib, which is not installed")
    try:
        protocol = Protocol(
            *(given.mode, given.train_levels, given.episodes, given.environments, given.seed),
            dict(map(parse_option, given.option)),
        )
        make_policy = load_policy(given.policy) if given.policy else random_policy
        evaluation = evaluate(games, make_policy, protocol, print_progress(), server=given.server)
    except ProcgenError as error:
        print(f"procgen-evaluate: {error}", file=sys.stderr)
        return 2
    policy = given.policy or "random policy"
    print(score_report.table(evaluation))
    if given.json:
        results = score_report.results(evaluation, policy)
        Path(given.json).write_text(json.dumps(results, indent=1, allow_nan=False) + "\n")
    if given.plot:
        score_report.plot(evaluation, policy, given.plot)
    return 0


def parse_option(text: str) -> tuple[str, Any]:
    """Returns name and value of "NAME=VALUE"; a value that is not JSON is text."""
    name, _, value = text.partition("=")
    try:
        return name, json.loads(value.lower() if value in ("True", "False") else value)
    except json.JSONDecodeError:
        return name, value


def _parser() -> argparse.ArgumentParser:
    default = Protocol()
    parser = argparse.ArgumentParser(
        prog="procgen-evaluate",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("games", nargs="*", default=["all"], help="games; default: all sixteen")
    parser.add_argument("--policy", metavar="MODULE:FUNCTION", help="default: a random policy")
    parser.add_argument(
        "--option",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help=f"of the environments, repeatable; one of {', '.join(POLICY_OPTIONS)}",
    )
    parser.add_argument("--server", help="address; default: PROCGEN_SERVER, else in this process")
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
    parser.add_argument(
        "--seed", type=int, default=0, help="of levels and bootstrap; default: %(default)s"
    )
    parser.add_argument("--plot", metavar="FILE", help="draw the scores")
    parser.add_argument("--json", metavar="FILE", help="write scores and all episodes")
    return parser


if __name__ == "__main__":
    sys.exit(main())
