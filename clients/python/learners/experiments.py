"""The experiments of the paper, one command each: a grid of runs, a figure, a table.

    python3 -m learners.experiments generalization --scale small --games coinrun bigfish

The same command resumes an interrupted experiment: it keeps finished runs and continues a stopped
one. DIR/EXPERIMENT-SCALE has a folder for each run, table.md and, with matplotlib, curves.png;
that of generalization also levels.png.
"""

from __future__ import annotations

import argparse
import json
import signal
import subprocess
import sys
import zlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from learners import checkpoint_file, report
from learners.environments import games_with_mode, return_range_or_none
from learners.policy import load_run
from learners.rainbow import REPLAY
from learners.run_folder import CHECKPOINT
from learners.training_run import PROGRESS_COLUMNS
from procgen_client import ACTION_COUNT, ENV_NAMES
from procgen_client.tools.play_episodes import play_episodes

TEST_ENV_COUNT = 50
SMALL_GAMES = ("bigfish", "coinrun", "starpilot")
# Of all_games, three games, and two whose returns are close to the random agent's.
THREE_SEED_GAMES = (*SMALL_GAMES, "climber", "leaper")
RANDOM_SEEDS = 3
RANDOM_EPISODE_COUNT = 1000  # Of each; they take seconds.
_TEST = "test.json"  # Returns of a run's policy.


class Scale(NamedTuple):
    """The size of an experiment."""

    mode: str  # Distribution mode.
    levels: int  # Number of training levels, unless an experiment varies it.
    total_steps: int
    network: str
    games: tuple[str, ...]  # If the mode is one of theirs, else all that have it.
    seeds: int  # Runs of each variant.
    episode_count: int  # Of a policy's test, per set of levels.
    num_envs: int = 64  # Of PPO.


SCALES = {
    "small": Scale("easy", 200, 150_000, "nature", SMALL_GAMES, 1, 100),
    "easy": Scale("easy", 200, 25_000_000, "impala", ENV_NAMES, 3, 1000),
    "paper": Scale("hard", 500, 200_000_000, "impala", ENV_NAMES, 3, 1000, 256),
}


class Variant(NamedTuple):
    """A curve of the figure: a learner with options."""

    label: str
    options: dict[str, Any]  # Of the learner, by their names with _; True: a flag.
    program: str = "ppo"


class Experiment(NamedTuple):
    """A grid of variants, games and seeds."""

    description: str
    variants: Callable[[Scale], list[Variant]]
    change: Callable[[Scale], Scale] = lambda scale: scale
    test_levels: int | None = 0  # Number of test levels, 0: all; None: no test.
    seeds_of: Callable[[str, Scale], int] = lambda game, scale: scale.seeds
    has_random_agent: bool = False
    varies_levels: bool = False  # The variants are numbers of training levels.


def _generalization(scale: Scale) -> list[Variant]:
    is_small = scale.total_steps < 1_000_000
    counts = (1, 10, 100, 1000) if is_small else (100, 200, 500, 1000, 10_000, 100_000)
    return [Variant(f"{count} levels", {"levels": count}) for count in counts]


def _network_size(scale: Scale) -> list[Variant]:
    sizes = [Variant("Nature CNN", {"network": "nature"})]
    widths = (1, 2) if scale.total_steps < 1_000_000 else (1, 2, 4)
    sizes += [Variant(f"IMPALA x {w}", {"network": "impala", "width": w}) for w in widths]
    return sizes


def _one(label: str, **options: Any) -> Callable[[Scale], list[Variant]]:  # noqa: ANN401
    return lambda scale: [Variant(label, options)]


EXPERIMENTS = {
    "all_games": Experiment(
        "PPO with Nature CNN on 200 easy levels of each game, 2M steps, beside a random agent",
        _one("PPO"),
        change=lambda scale: SCALES["small"]._replace(total_steps=2_000_000, games=ENV_NAMES),
        seeds_of=lambda game, scale: 3 if game in THREE_SEED_GAMES else 1,
        has_random_agent=True,
    ),
    "sample_efficiency": Experiment(
        "PPO on all levels", _one("PPO", levels=0), test_levels=None
    ),
    "generalization": Experiment(
        "from a number of levels to all levels", _generalization, varies_levels=True
    ),
    "network_size": Experiment("IMPALA of several widths, and Nature CNN", _network_size),
    "rainbow_vs_ppo": Experiment(
        "two algorithms on all levels",
        lambda scale: [
            Variant("PPO", {"levels": 0}),
            Variant("Rainbow", {"levels": 0, "num_envs": 64} | _small_replay(scale), "rainbow"),
        ],
        test_levels=None,
    ),
    "sequential_levels": Experiment(
        "one sequence of levels, and random sequences; an episode plays its levels in turn",
        lambda scale: [
            Variant("one sequence", {"levels": 1, "sequential_levels": True}),
            Variant("random sequences", {"levels": 0, "sequential_levels": True}),
        ],
    ),
    "exploration": Experiment(
        "exploration mode, which has one level",
        _one("PPO", levels=0),
        change=lambda scale: scale._replace(mode="exploration"),
        test_levels=None,
    ),
    "memory": Experiment(
        "all levels of memory mode, policy without memory",
        _one("PPO", levels=0),
        change=lambda scale: scale._replace(mode="memory"),
        test_levels=None,
    ),
}


def _small_replay(scale: Scale) -> dict[str, Any]:
    if scale.total_steps >= 1_000_000:
        return {}
    return {"replay_size": 50_000, "learning_starts": 5000, "target_interval": 3200}


class Job(NamedTuple):
    """A run of the grid."""

    game: str
    variant: Variant
    seed: int
    folder: Path


def jobs_of(experiment: Experiment, scale: Scale, root: Path) -> Iterator[Job]:
    """Yields the runs, ordered by seed, then by game."""
    for seed in range(max(experiment.seeds_of(game, scale) for game in scale.games)):
        for game in scale.games:
            if seed < experiment.seeds_of(game, scale):
                for variant in experiment.variants(scale):
                    name = variant.label.replace(" ", "_")
                    yield Job(game, variant, seed, root / game / name / f"seed{seed}")


def is_finished(job: Job, experiment: Experiment, scale: Scale) -> bool:
    """Returns whether a run has reached its last step; without a checkpoint, if tested."""
    if (job.folder / CHECKPOINT).exists():
        return checkpoint_file.load(job.folder / CHECKPOINT)["step"] >= scale.total_steps
    is_tested = experiment.test_levels is None or (job.folder / _TEST).exists()
    progress = job.folder / "progress.csv"
    if not is_tested or not progress.exists():
        return False
    return int(progress.read_text().splitlines()[-1].split(",")[0]) >= scale.total_steps


def train(job: Job, scale: Scale, more: Sequence[str]) -> None:
    """Runs a learner to its last step; continues a stopped run.

    Raises:
        SystemExit: It was stopped, or failed.
    """
    options = {
        "game": job.game,
        "mode": scale.mode,
        "levels": scale.levels,
        "network": scale.network,
        "num_envs": scale.num_envs,
        "total_steps": scale.total_steps,
        "seed": job.seed,
        "output": job.folder,
        "resume": True,
    } | job.variant.options
    words: list[str] = []
    for name, value in options.items():
        words += [f"--{name.replace('_', '-')}", *([] if value is True else [str(value)])]
    command = [sys.executable, "-m", f"learners.{job.variant.program}", *words, *more]
    with subprocess.Popen(command) as process:
        # Ctrl-C reaches the learner, which saves its state before it ends.
        handlers = {n: signal.signal(n, lambda n, _: process.send_signal(n)) for n in _SIGNALS}
        status = process.wait()
        for number, handler in handlers.items():
            signal.signal(number, handler)
    if status:
        raise SystemExit(status)
    (job.folder / REPLAY).unlink(missing_ok=True)  # Up to 13 GB.


_SIGNALS = (signal.SIGTERM, signal.SIGINT)


def test(job: Job, experiment: Experiment, scale: Scale, server: str | None) -> None:
    """Plays the trained policy on training and test levels, and writes the returns."""
    path = job.folder / _TEST
    if experiment.test_levels is None or path.exists():
        return
    options = job.variant.options
    is_sequential = options.get("sequential_levels", False)
    sets = {"train": options.get("levels", scale.levels), "test": experiment.test_levels}
    returns = {}
    for name, num_levels in sets.items():
        played = _play(
            *(job.game, load_run(job.folder, job.game), scale, 0),
            server=server,
            num_levels=num_levels,
            use_sequential_levels=is_sequential,
        )
        returns[name] = played.mean(1).tolist()
    path.write_text(json.dumps(returns) + "\n")


def random_baseline(game: str, scale: Scale, root: Path, server: str | None) -> list[float]:
    """Returns the mean returns of RANDOM_SEEDS runs of a random agent."""
    path = root / game / "random.json"
    if not path.exists():
        scale = scale._replace(episode_count=RANDOM_EPISODE_COUNT)
        means = []
        for seed in range(RANDOM_SEEDS):
            random = np.random.default_rng([zlib.crc32(game.encode()), seed])

            def act(observations: np.ndarray, random: Any = random) -> np.ndarray:  # noqa: ANN401
                return random.integers(0, ACTION_COUNT, len(observations))

            played = _play(game, act, scale, seed, server=server, num_levels=scale.levels)
            means.append(float(played.mean()))
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(means) + "\n")
    return json.loads(path.read_text())


def _play(
    game: str,
    act: Callable[[np.ndarray], Any],
    scale: Scale,
    seed: int,
    **options: Any,  # noqa: ANN401
) -> np.ndarray:
    """Returns the returns of episodes, [environments, episodes of each]."""
    env_count = min(TEST_ENV_COUNT, scale.episode_count)
    played = play_episodes(
        *(game, act),
        env_count=env_count,
        episodes_per_env=-(-scale.episode_count // env_count),
        distribution_mode=scale.mode,
        rand_seed=seed,
        **options,
    )
    return np.float32([[episode.episode_return for episode in each] for each in played])


def run_of(job: Job, scale: Scale) -> report.Run:
    """Reads the results of a run."""
    columns = np.genfromtxt(
        job.folder / "progress.csv", delimiter=",", skip_header=1, usecols=(0, 1), ndmin=2
    )
    assert PROGRESS_COLUMNS[:2] == ("step", "return_mean")
    path = job.folder / _TEST
    tested = json.loads(path.read_text()) if path.exists() else {}
    means = {name: float(np.mean(returns)) for name, returns in tested.items()}
    return report.Run(
        *(job.game, job.variant.label, job.seed, columns[:, 0], columns[:, 1]),
        *(means.get("train"), means.get("test")),
        job.variant.options.get("levels", scale.levels),
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line; returns the exit status."""
    given, more = _parser().parse_known_args(arguments)
    experiment = EXPERIMENTS[given.name]
    scale = experiment.change(SCALES[given.scale])
    playable = games_with_mode(scale.mode)
    games = [game for game in given.games or scale.games if game in playable]
    if not games and given.games:
        raise SystemExit(f"none of these games has mode {scale.mode}; {', '.join(playable)} have")
    games = games or playable
    scale = scale._replace(games=tuple(games))
    if given.total_steps is not None:
        scale = scale._replace(total_steps=given.total_steps)
    if given.seeds is not None:
        experiment = experiment._replace(seeds_of=lambda game, scale: given.seeds)
    if given.server:
        more += ["--server", given.server]
    root = Path(given.output) / f"{given.name}-{given.scale}"
    jobs = list(jobs_of(experiment, scale, root))
    done = []
    for number, job in enumerate(jobs, 1):
        label = f"{job.game}, {job.variant.label}, seed {job.seed}"
        print(f"[{number}/{len(jobs)}] {label}", flush=True)
        if not is_finished(job, experiment, scale):
            train(job, scale, more)
        test(job, experiment, scale, given.server)
        done.append(run_of(job, scale))
    ranges = {game: return_range_or_none(game, scale.mode) for game in games}
    random = {}
    if experiment.has_random_agent:
        random = {game: random_baseline(game, scale, root, given.server) for game in games}
    title = f"{given.name}: {experiment.description}"
    (root / "table.md").write_text(report.table(done, ranges, random) + "\n")
    report.plot(done, ranges, random, title, root / "curves.png")
    if experiment.varies_levels:
        report.plot_levels(done, title, root / "levels.png")
    print((root / "table.md").read_text())
    return 0


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
    parser.add_argument("--server", help="address; default: PROCGEN_SERVER, else in this process")
    return parser


if __name__ == "__main__":
    sys.exit(main())
