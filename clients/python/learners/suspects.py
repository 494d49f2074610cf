"""Short runs of PPO that each change one thing, beside OpenAI's published runs.

    PROCGEN_ART=procgen python3 -m learners.suspects --jobs 4 --output suspects --time-limit 780

A quarter of an hour on a GPU: bigfish, 200 easy levels, 1M steps. Seeds take turns, so that an
early end loses seeds, not variants; the same command continues. Each run has a folder with CSV
files. DIR/table.md compares the variants with OpenAI's runs as learners.published does.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from learners import published
from learners.experiments import last_step
from learners.options import words_of
from learners.processes import Processes, Program, add_process_options
from learners.run_folder import CHECKPOINT

VARIANTS: dict[str, dict[str, Any]] = {
    "default": {},
    "pytorch_adam": {"adam": "pytorch"},
    "pytorch_init": {"init": "pytorch"},
    "reward_gamma_999": {"reward_gamma": 0.999},
    "all_three": {"adam": "pytorch", "init": "pytorch", "reward_gamma": 0.999},
    "float32": {"precision": "float32"},
    # On a GPU: PyTorch's layers, neither graphs nor compilation.
    "eager": {"eager": True},
    "not_compiled": {"compile": False},
}
SEEDS = 3
_COLUMNS = ("return", "kl", "clip_fraction", "entropy", "value_loss", "explained_variance")


def table(root: Path) -> str:
    """Returns the comparison of the finished runs as a Markdown table."""
    lines = [f"| variant | seeds | step | {' | '.join(_COLUMNS)} |"]
    lines.append(f"| --- |{' ---: |' * (2 + len(_COLUMNS))}")
    for name in VARIANTS:
        folders = [path.parent for path in sorted(root.glob(f"{name}/seed*/{CHECKPOINT}"))]
        for step, columns in (published.distances(folders) if folders else {}).items():
            cells = (f"{columns[c][0]:.4g} ({columns[c][1]:+.1f})" for c in _COLUMNS)
            lines.append(f"| {name} | {len(folders)} | {step:,} | {' | '.join(cells)} |")
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line; returns the exit status."""
    parser = argparse.ArgumentParser(
        prog="python3 -m learners.suspects",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Other options are passed to learners.ppo.",
        allow_abbrev=False,
    )
    parser.add_argument("--game", default="bigfish", help="default: %(default)s")
    parser.add_argument("--total-steps", type=int, default=1_000_000, help="of each run")
    parser.add_argument("--output", type=Path, default=Path("suspects"), metavar="DIR")
    add_process_options(parser)
    parser.add_argument("--variants", nargs="+", choices=VARIANTS, default=list(VARIANTS))
    given, more = parser.parse_known_args(arguments)

    def write_table() -> None:
        (given.output / "table.md").write_text(table(given.output) + "\n")

    def programs() -> Iterator[Program]:
        for seed in range(SEEDS):
            for name in given.variants:
                folder = given.output / name / f"seed{seed}"
                if last_step(folder) >= given.total_steps:
                    continue
                options = {"game": given.game, "total_steps": given.total_steps, "seed": seed}
                options |= {"output": folder, "resume": True} | VARIANTS[name]
                command = [sys.executable, "-m", "learners.ppo", *words_of(options), *more]
                yield Program(f"{name}, seed {seed}", command, write_table)

    status = Processes(given.jobs, given.time_limit).run(programs())
    print(table(given.output))
    return status


if __name__ == "__main__":
    sys.exit(main())
