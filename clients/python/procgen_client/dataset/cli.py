"""procgen-dataset: records data sets as seeds and actions, and draws their frames again.

    procgen-dataset record coinrun maze --steps 1000000 --output data
    procgen-dataset info data
    procgen-dataset replay data --verify
    procgen-dataset replay data --format webdataset --output frames

A recording has half a byte per step. `replay` draws its frames again, byte for byte, in a format of
other libraries: npz (segments as archives of numpy), webdataset (segments in tar files) or minari
(episodes in HDF5). --verify writes nothing. Both compare rewards, ends and levels of every step
with the recorded ones, and frames with recorded digests.

A command that was interrupted or killed continues when it is repeated. Variables PROCGEN_SERVER and
PROCGEN_ART are as for all pools; a data set is not recorded on a server.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from procgen_client.dataset import jobs
from procgen_client.dataset.expansion import Expansion, Replay, expand, finish, prepare
from procgen_client.dataset.formats import FORMATS, format_of
from procgen_client.dataset.policies import STICKINESS
from procgen_client.dataset.recording import parts_of, record
from procgen_client.dataset.trajectories import find, load
from procgen_client.errors import InvalidArgumentError, ProcgenError
from procgen_client.options import GAMES
from procgen_client.tools.evaluate import parse_option
from procgen_client.tools.progress import ProgressLine


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line; returns the exit status, 2 after an error, 130 after Ctrl-C."""
    given = _parser().parse_args(arguments)
    try:
        given.command(given)
    except (ProcgenError, OSError) as error:
        print(f"procgen-dataset: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("\nprocgen-dataset: interrupted; repeat the command to continue", file=sys.stderr)
        return 130
    return 0


def _record(given: argparse.Namespace) -> None:
    options = dict(map(parse_option, given.option))
    for name in ("distribution_mode", "num_levels", "start_level"):
        if getattr(given, name) is not None:
            options[name] = getattr(given, name)
    if "rand_seed" in options:
        raise InvalidArgumentError("rand_seed is an option of its own: --seed")
    expansion = _expansion(given, given.frames)
    parts = parts_of(
        given.output,
        list(GAMES) if given.games == ["all"] else given.games,
        step_count=given.steps,
        env_count=given.environments,
        policy=given.policy,
        seed=given.seed,
        art=given.art,
        digest_interval=given.digest_interval,
        options=options,
    )
    given.output.mkdir(parents=True, exist_ok=True)
    waiting = [part for part in parts if not part.is_done]
    line = ProgressLine("recorded", sum(part.step_count for part in waiting))
    jobs.run(record, waiting, given.workers, line.show)
    if given.format is not None:
        _expand([part.path for part in parts], expansion, given.workers)


def _replay(given: argparse.Namespace) -> None:
    if (given.format is None) != given.verify:
        raise InvalidArgumentError("give either --verify or --format")
    expansion = _expansion(given, given.output)
    _expand(find(given.paths), expansion, given.workers)


def _expansion(given: argparse.Namespace, folder: Path | None) -> Expansion:
    if (given.format is None) != (folder is None):
        raise InvalidArgumentError("--format needs a folder for frames, and the folder --format")
    if given.format is not None:
        format_of(given.format, given.segment_length)
    elif given.screen_size is not None:
        raise InvalidArgumentError("--screen-size needs --format: digests are of 64 x 64 pixels")
    if given.workers < 1:
        raise InvalidArgumentError(f"workers is {given.workers}; it is at least 1")
    return Expansion(
        given.format,
        folder or Path(),
        given.segment_length,
        given.art if given.command is _replay else None,
        {} if given.screen_size is None else {"screen_size": given.screen_size},
    )


def _expand(paths: Sequence[Path], expansion: Expansion, workers: int) -> None:
    prepare(paths, expansion)
    steps = sum(load(path).actions.size for path in paths)
    line = ProgressLine("replayed", steps)
    jobs.run(expand, [Replay(path, expansion) for path in paths], workers, line.show)
    finish(paths, expansion)


def _info(given: argparse.Namespace) -> None:
    print("| file | steps | environments | episodes | mean return | levels | policy |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | --- |")
    for path in find(given.paths):
        trajectories = load(path)
        episodes = int(trajectories.ended.sum())
        mean = f"{_mean_return(trajectories.rewards, trajectories.ended):.2f}" if episodes else "-"
        levels = len(np.unique(trajectories.level_seeds))
        header = trajectories.header
        print(
            f"| {path} | {trajectories.actions.size:,} | {header.env_count} | {episodes:,} "
            f"| {mean} | {levels:,} | {header.policy or '-'} |"
        )


def _mean_return(rewards: np.ndarray, ended: np.ndarray) -> float:
    """Returns the mean return of all episodes that ended."""
    total = 0.0
    for row, ends in zip(rewards, ended):
        last = np.flatnonzero(ends)
        total += float(row[: last[-1] + 1].sum()) if len(last) else 0.0
    return total / int(ended.sum())


def _parser() -> argparse.ArgumentParser:
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(
        prog="procgen-dataset", description=__doc__, formatter_class=raw
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    one = commands.add_parser("record", help="let a policy play, and write trajectory files")
    one.set_defaults(command=_record)
    one.add_argument("games", nargs="+", help="games, or all")
    one.add_argument("--output", type=Path, required=True, metavar="FOLDER")
    one.add_argument("--steps", type=int, required=True, help="of each game; rounded up")
    one.add_argument("--environments", type=int, help="default: about 4,096 steps each")
    one.add_argument(
        "--policy",
        default="random",
        help=f"random; sticky[:P], which repeats an action with probability P (default: "
        f"{STICKINESS}); or MODULE:FUNCTION, as for procgen-evaluate. Default: %(default)s",
    )
    one.add_argument("--mode", dest="distribution_mode", help="default: hard")
    one.add_argument("--levels", dest="num_levels", type=int, help="default: 0, unlimited")
    one.add_argument("--start-level", dest="start_level", type=int, help="default: 0")
    one.add_argument("--seed", type=int, default=0, help="of policy and levels")
    one.add_argument(
        "--option", action="append", default=[], metavar="NAME=VALUE",
        help="another option of the environments, repeatable, such as use_backgrounds=false",
    )  # fmt: skip
    one.add_argument("--art", help="a folder, or procgen; default: PROCGEN_ART")
    one.add_argument(
        "--digest-interval", type=int, default=64, metavar="STEPS",
        help="steps from one digest of the frames to the next; default: %(default)s",
    )  # fmt: skip
    one.add_argument("--frames", type=Path, metavar="FOLDER", help="with --format: also expand")
    two = commands.add_parser("replay", help="draw the frames of trajectory files")
    two.set_defaults(command=_replay)
    two.add_argument("paths", nargs="+", type=Path, help="trajectory files and their folders")
    two.add_argument("--verify", action="store_true", help="compare only")
    two.add_argument("--output", type=Path, metavar="FOLDER", help="with --format")
    two.add_argument("--art", help="default: the recorded one")
    for each in (one, two):
        each.add_argument("--format", choices=FORMATS)
        each.add_argument(
            "--segment-length", type=int, default=64, metavar="STEPS",
            help="of npz and webdataset; default: %(default)s. A worker holds 64 segments",
        )  # fmt: skip
        each.add_argument("--screen-size", type=int, metavar="PIXELS", help="of the frames")
        each.add_argument(
            "--workers", type=int, default=len(os.sched_getaffinity(0)), metavar="N",
            help="processes; default: one for each core",
        )  # fmt: skip
    three = commands.add_parser("info", help="print a table of trajectory files")
    three.set_defaults(command=_info)
    three.add_argument("paths", nargs="+", type=Path, help="trajectory files and their folders")
    return parser


if __name__ == "__main__":
    sys.exit(main())
