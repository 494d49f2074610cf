"""The experiments of the paper as grids of variants, games and seeds."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from procgen_client import ENV_NAMES


class Scale(NamedTuple):
    """The size of an experiment."""

    mode: str  # Distribution mode.
    levels: int  # Number of training levels, unless an experiment varies it.
    total_steps: int
    network: str
    games: tuple[str, ...]  # If the mode is one of theirs, else all that have it.
    seeds: int  # Runs of each variant.
    num_envs: int = 64  # Of PPO.

    @property
    def test_interval(self) -> int:
        """Steps between two tests: a hundredth of a run."""
        return max(1, self.total_steps // 100)

    @property
    def is_small(self) -> bool:
        """Whether runs take minutes on a CPU."""
        return self.total_steps < 1_000_000


SCALES = {
    "small": Scale("easy", 200, 150_000, "nature", ("bigfish", "coinrun", "starpilot"), 1),
    "easy": Scale("easy", 200, 25_000_000, "impala", ENV_NAMES, 3),
    "paper": Scale("hard", 500, 200_000_000, "impala", ENV_NAMES, 3, 256),
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
    varies_levels: bool = False  # The variants are numbers of training levels.
    compares_learning: bool = False  # With the published losses, too.


def _generalization(scale: Scale) -> list[Variant]:
    counts = (1, 10, 100, 1000) if scale.is_small else (100, 200, 500, 1000, 10_000, 100_000)
    return [Variant(f"{count} levels", {"levels": count}) for count in counts]


def _network_size(scale: Scale) -> list[Variant]:
    networks: list[tuple[str, dict[str, Any]]] = [("Nature CNN", {"network": "nature"})]
    for width in (1, 2) if scale.is_small else (1, 2, 4):
        rate = 5e-4 / width**0.5  # As in the paper.
        options = {"network": "impala", "width": width, "learning_rate": rate}
        networks.append((f"IMPALA x {width}", options))
    return [
        Variant(f"{label}, {levels or 'all'} levels", options | {"levels": levels})
        for levels in (scale.levels, 0)
        for label, options in networks
    ]


def _rainbow_vs_ppo(scale: Scale) -> list[Variant]:
    options = {"levels": 0, "num_envs": 512, "replay_size": 8_000_000}  # Of eight workers.
    if scale.is_small:
        options |= {"num_envs": 64, "batch_size": 512, "replay_size": 50_000}
        options |= {"learning_starts": 5000}
    return [Variant("PPO", {"levels": 0}), Variant("Rainbow", options, "rainbow")]


def _suspects(scale: Scale) -> list[Variant]:
    one_by_one: dict[str, dict[str, Any]] = {
        "default": {},
        "pytorch adam": {"adam": "pytorch"},
        "pytorch init": {"init": "pytorch"},
        "reward gamma 999": {"reward_gamma": 0.999},
        "all three": {"adam": "pytorch", "init": "pytorch", "reward_gamma": 0.999},
        "float32": {"precision": "float32"},
        # On a GPU: PyTorch's layers, neither graphs nor compilation.
        "eager": {"eager": True},
        "not compiled": {"compile": False},
    }
    return [Variant(label, its | {"test_interval": None}) for label, its in one_by_one.items()]


def _one(**options: Any) -> Callable[[Scale], list[Variant]]:  # noqa: ANN401
    return lambda scale: [Variant("PPO", options)]


def _four_seeds(scale: Scale) -> Scale:
    """Returns a scale with as many seeds as the paper's figures 2 and 3."""
    return scale._replace(seeds=4) if scale == SCALES["paper"] else scale


EXPERIMENTS = {
    "baseline": Experiment(
        "PPO on 200 easy or 500 hard levels, tested on all, beside OpenAI's runs", _one()
    ),
    "sample_efficiency": Experiment("PPO on all levels", _one(levels=0)),
    "generalization": Experiment(
        *("from a number of levels to all levels", _generalization, _four_seeds),
        varies_levels=True,
    ),
    "network_size": Experiment(
        "IMPALA of several widths and Nature CNN, on a number of levels and on all",
        _network_size,
    ),
    "recurrence": Experiment(
        "one frame, a stack of four frames, an LSTM",
        lambda scale: [
            Variant("PPO", {}),
            Variant("frame stack", {"frame_stack": 4}),
            Variant("LSTM", {"lstm": True}),
        ],
    ),
    "rainbow_vs_ppo": Experiment("two algorithms on all levels", _rainbow_vs_ppo),
    "sequential_levels": Experiment(
        "one sequence of easy levels, tested on random ones; an episode plays its levels in turn",
        lambda scale: [Variant("one sequence", {"levels": 1, "sequential_levels": True})],
        change=lambda scale: _four_seeds(scale)._replace(mode="easy"),
    ),
    "exploration": Experiment(
        "exploration mode, which has one level",
        _one(levels=0),
        change=lambda scale: scale._replace(mode="exploration"),
    ),
    "suspects": Experiment(
        "short runs that each change one thing, beside OpenAI's losses, too",
        _suspects,
        lambda _: SCALES["easy"]._replace(games=("bigfish",), total_steps=1_000_000),
        compares_learning=True,
    ),
    "memory": Experiment(
        "all levels of memory mode, policy without memory",
        _one(levels=0),
        change=lambda scale: scale._replace(mode="memory"),
    ),
}


class Job(NamedTuple):
    """A run of the grid."""

    game: str
    variant: Variant
    seed: int
    folder: Path

    def options(self, scale: Scale) -> dict[str, Any]:
        """Returns the options of the learner."""
        options: dict[str, Any] = {
            "game": self.game,
            "mode": scale.mode,
            "levels": scale.levels,
            "network": scale.network,
            "num_envs": scale.num_envs,
            "total_steps": scale.total_steps,
            "seed": self.seed,
            "output": self.folder,
            "resume": True,
        }
        options |= self.variant.options
        if options["levels"] != 0:
            options.setdefault("test_interval", scale.test_interval)
        return options


def jobs_of(experiment: Experiment, scale: Scale, root: Path) -> Iterator[Job]:
    """Yields the runs, ordered by seed, then by game."""
    for seed in range(scale.seeds):
        for game in scale.games:
            for variant in experiment.variants(scale):
                name = variant.label.replace(",", "").replace(" ", "_")
                yield Job(game, variant, seed, root / game / name / f"seed{seed}")
