"""The experiments of the paper, one command each: a grid of runs, a figure, a table.

    python3 -m learners.experiments generalization --scale small --games coinrun bigfish

The same command resumes an interrupted experiment: it keeps finished runs and continues stopped
ones. --jobs runs several side by side. DIR/EXPERIMENT-SCALE has a folder for each run, table.md
and, with matplotlib, curves.png; that of generalization also levels.png. --report writes them from
the runs that are there.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from learners import checkpoint_file, published, report
from learners.environments import games_with_mode, return_range_or_none
from learners.grid import EXPERIMENTS, SCALES, Experiment, Job, Scale, jobs_of
from learners.options import words_of
from learners.processes import Processes, Program, add_process_options
from learners.rainbow import REPLAY
from learners.run_folder import CHECKPOINT
from procgen_client import ENV_NAMES

# Options of runs that are comparable with the published ones.
_PUBLISHED_OPTIONS = {
    *("game", "mode", "levels", "network", "num_envs", "total_steps", "seed", "output"),
    *("resume", "test_interval"),
}


def last_step(folder: Path) -> int:
    """Returns the last step of a run; of its checkpoint, if there is one."""
    if (folder / CHECKPOINT).exists():
        step: int = checkpoint_file.load(folder / CHECKPOINT)["step"]
        return step
    steps = read_columns(folder / "progress.csv")[0]
    return int(steps[-1]) if steps.size else 0


def program_of(job: Job, scale: Scale, more: Sequence[str], label: str) -> Program:
    """Returns a learner that runs to its last step, or continues a stopped run."""
    words = words_of(job.options(scale))
    command = [sys.executable, "-m", f"learners.{job.variant.program}", *words, *more]
    replay = job.folder / REPLAY  # Up to 103 GB.
    return Program(label, command, lambda: replay.unlink(missing_ok=True))


def read_columns(path: Path) -> np.ndarray:
    """Returns step and return_mean of a CSV file, [2, rows]; no rows if there is no file."""
    rows = path.read_text().splitlines()[1:] if path.exists() else []
    if not rows:  # Also of a run that was stopped before its first test.
        return np.zeros((2, 0))
    return np.genfromtxt(rows, delimiter=",", usecols=(0, 1), ndmin=2).T


def run_of(job: Job, scale: Scale) -> report.Run:
    """Reads the results of a run, which may have none yet."""
    options = job.options(scale)
    openai: dict[str, dict[int, published.Row]] = {}
    if job.variant.program == "ppo" and options.keys() <= _PUBLISHED_OPTIONS:
        openai = {
            split: published.by_step(job.game, scale.mode, options["levels"], split)
            for split in ("train", "test")
            if options["network"] == "impala" and (split == "train" or options["levels"])
        }
    return report.Run(
        *(job.game, job.variant.label, job.seed, options["levels"]),
        *read_columns(job.folder / "progress.csv"),
        *read_columns(job.folder / "test.csv"),
        openai,
    )


def write_report(name: str, experiment: Experiment, scale: Scale, root: Path) -> None:
    """Writes table and figures of the runs that are there, and prints the table."""
    jobs = list(jobs_of(experiment, scale, root))
    runs = [run_of(job, scale) for job in jobs]
    ranges = {game: return_range_or_none(game, scale.mode) for game in scale.games}
    title = f"{name}: {experiment.description}"
    root.mkdir(parents=True, exist_ok=True)
    tables = [report.table(runs, ranges)]
    if experiment.compares_learning:
        saved: dict[str, list[Path]] = {}
        for job in jobs:
            if (job.folder / CHECKPOINT).exists():
                saved.setdefault(f"{job.game}, {job.variant.label}", []).append(job.folder)
        tables.append(published.table(saved))
    (root / "table.md").write_text("\n\n".join(tables) + "\n")
    done = [run for run in runs if run.steps.size]
    if done:
        report.plot(done, ranges, title, root / "curves.png")
        if experiment.varies_levels:
            report.plot_levels(done, title, root / "levels.png")
    print((root / "table.md").read_text())


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line; returns the exit status."""
    given, more = _parser().parse_known_args(arguments)
    experiment = EXPERIMENTS[given.name]
    scale = experiment.change(SCALES[given.scale])
    playable = games_with_mode(scale.mode)
    games = [game for game in given.games or scale.games if game in playable]
    if not games and given.games:
        raise SystemExit(f"none of these games has mode {scale.mode}; {', '.join(playable)} have")
    scale = scale._replace(games=tuple(games or playable))
    if given.total_steps is not None:
        scale = scale._replace(total_steps=given.total_steps)
    if given.seeds is not None:
        scale = scale._replace(seeds=given.seeds)
    if given.server:
        more += ["--server", given.server]
    root = Path(given.output) / f"{given.name}-{given.scale}"
    jobs = [] if given.report else list(jobs_of(experiment, scale, root))
    labels = (f"{job.game}, {job.variant.label}, seed {job.seed}" for job in jobs)
    status = Processes(given.jobs, given.time_limit).run(
        program_of(job, scale, more, f"[{number}/{len(jobs)}] {label}")
        for number, (job, label) in enumerate(zip(jobs, labels, strict=True), 1)
        if last_step(job.folder) < scale.total_steps
    )
    write_report(given.name, experiment, scale, root)
    return status


def _parser() -> argparse.ArgumentParser:
    described = "\n".join(f"  {name:18} {its.description}" for name, its in EXPERIMENTS.items())
    parser = argparse.ArgumentParser(
        prog="python3 -m learners.experiments",
        description=f"{__doc__}\nexperiments:\n{described}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Other options are passed to the learners of all runs.",
        allow_abbrev=False,  # --seed is an option of the learners.
    )
    parser.add_argument("name", choices=EXPERIMENTS, metavar="EXPERIMENT")
    parser.add_argument("--games", nargs="+", choices=ENV_NAMES, metavar="GAME")
    parser.add_argument("--scale", choices=SCALES, default="small", help="default: %(default)s")
    parser.add_argument("--total-steps", type=int, help="default: the scale's")
    parser.add_argument("--seeds", type=int, help="of each variant; default: the experiment's")
    parser.add_argument("--output", default="experiments", metavar="DIR")
    add_process_options(parser)
    parser.add_argument("--server", help="address; default: PROCGEN_SERVER, else in this process")
    parser.add_argument("--report", action="store_true", help="run nothing")
    return parser


if __name__ == "__main__":
    sys.exit(main())
