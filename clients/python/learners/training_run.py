"""The loop of a training run: updates, progress, checkpoints, clean stops."""

from __future__ import annotations

import argparse
import signal
import time
from collections import deque
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np

from learners import checkpoint_file
from learners.environments import Episode
from learners.evaluation import EPISODE_WINDOW, TEST_COLUMNS, PeriodicEvaluation
from learners.ranks import Ranks
from learners.run_folder import CHECKPOINT, RunFolder
from procgen_client.tools.progress import ProgressLine

PROGRESS_COLUMNS = (
    *("step", "return_mean", "length_mean", "steps_per_second"),
    *("environment_share", "policy_share", "learning_share"),
)
EPISODE_COLUMNS = ("step", "environment", "level_seed", "return", "length")
# Options that do not affect results; they may differ when a run is continued.
FREE_OPTIONS = {
    *("total_steps", "output", "server", "server_timeout", "resume", "time_limit"),
    *("checkpoint_interval", "threads", "config", "wandb", "watch"),
}


class Update(NamedTuple):
    """The result of an update of one rank."""

    step_count: int  # Steps of each environment.
    episodes: list[Episode]
    environment_seconds: float  # Time of waiting for environments.
    policy_seconds: float  # Time of choosing actions.
    metrics: Sequence[float]  # Of Learner.metric_names.


class Learner(Protocol):
    """An algorithm."""

    @property
    def metric_names(self) -> tuple[str, ...]:
        """Names of Update.metrics."""

    @property
    def needs_checkpoint(self) -> bool:
        """Whether a checkpoint must be saved before the next update."""

    def update(self) -> Update:
        """Collects experience and learns from it."""

    def state(self) -> dict[str, Any]:
        """Returns the state that all ranks share, for a checkpoint."""

    def rank_state(self) -> dict[str, Any]:
        """Returns the state of this rank."""

    def restore(self, state: dict[str, Any], rank_state: dict[str, Any]) -> None:
        """Continues from a checkpoint."""


class TrainingRun:
    """Updates a learner until the last step, the time limit or a signal."""

    def __init__(
        self,
        options: argparse.Namespace,
        learner: Learner,
        ranks: Ranks,
        evaluation: PeriodicEvaluation | None = None,
    ) -> None:
        """Opens the run's folder; with options.resume, continues from its checkpoint.

        `evaluation`: is played every options.test_interval steps; only on rank 0.

        Raises:
            SystemExit: The folder has a checkpoint, without options.resume or of other options.
        """
        self._options, self._learner, self._ranks = options, learner, ranks
        self._evaluation = evaluation
        self._step = 0
        self._recent: deque[tuple[float, int]] = deque(maxlen=EPISODE_WINDOW)
        self._signal = 0
        path = Path(options.output)
        checkpoint = None
        if (path / CHECKPOINT).exists():
            if not options.resume:
                raise SystemExit(f"{path} has a checkpoint; --resume continues from it")
            checkpoint = checkpoint_file.load(path / CHECKPOINT)
            self._require_same_options(checkpoint)
            learner.restore(checkpoint["learner"], checkpoint["ranks"][ranks.rank])
            if evaluation is not None:
                evaluation.restore(checkpoint["evaluation"])
            self._step = checkpoint["step"]
            self._recent.extend(checkpoint["recent"])
        self._folder = None
        if ranks.rank == 0:
            columns = {
                "progress": PROGRESS_COLUMNS,
                "episodes": EPISODE_COLUMNS,
                "learning": ("step", *learner.metric_names),
            }
            if evaluation is not None:
                columns["test"] = TEST_COLUMNS
            sizes = checkpoint and checkpoint["sizes"]
            self._folder = RunFolder(path, columns, sizes, vars(options))
        self._progress = ProgressLine(options.game, options.total_steps, interval_s=30)

    def _require_same_options(self, checkpoint: dict[str, Any]) -> None:
        before = checkpoint["options"] | {"ranks": len(checkpoint["ranks"])}
        for name, value in (vars(self._options) | {"ranks": self._ranks.count}).items():
            if name not in FREE_OPTIONS and before.get(name) != value:
                raise SystemExit(
                    f"{self._options.output} was begun with {name} {before.get(name)}, not {value}"
                )

    def train(self) -> int:
        """Runs; returns the exit status: 128 plus the number of a signal, or 0."""
        numbers = (signal.SIGINT, signal.SIGTERM)
        handlers = [signal.signal(number, self._on_signal) for number in numbers]
        try:
            self._update_until_end()
        finally:
            for number, handler in zip(numbers, handlers, strict=True):
                signal.signal(number, handler)
            if self._folder is not None:
                self._folder.close()
        return 128 + self._signal if self._signal else 0

    def _update_until_end(self) -> None:
        begin = last_save = time.monotonic()
        limit = self._options.time_limit
        while self._step < self._options.total_steps:
            self._update()
            now = time.monotonic()
            is_due = now - last_save >= self._options.checkpoint_interval
            is_due = is_due or self._learner.needs_checkpoint
            is_over = self._signal or (limit is not None and now - begin >= limit)
            decision = self._ranks.largest(2 if is_over else int(is_due))
            if decision:
                self._save()
                last_save = now
            if decision == 2:
                return
        self._save()

    def _on_signal(self, number: int, frame: Any) -> None:  # noqa: ANN401
        self._signal = number

    def _update(self) -> None:
        begin = time.perf_counter()
        update = self._learner.update()
        seconds = time.perf_counter() - begin
        env_count = self._options.num_envs
        gathered = self._ranks.gather(update.episodes)
        rows = sorted(
            (
                self._step + episode.t * env_count * self._ranks.count,
                rank * env_count + episode.environment,
                *episode[2:],
            )
            for rank, episodes in enumerate(gathered)
            for episode in episodes
        )
        before = self._step
        self._step += update.step_count * env_count * self._ranks.count
        self._recent.extend((row[3], row[4]) for row in rows)
        if self._folder is not None:
            self._folder.write("episodes", rows)
            self._report(update, seconds)
            if self._evaluation is not None:
                interval = self._options.test_interval
                if self._step // interval > before // interval:
                    self._test(self._folder, self._evaluation)

    def _test(self, folder: RunFolder, evaluation: PeriodicEvaluation) -> None:
        means = evaluation.play()
        folder.write("test", [[self._step, *means]])
        values = zip(TEST_COLUMNS[1:], means, strict=True)
        folder.plot(self._step, {f"test_{name}": value for name, value in values if value != ""})

    def _report(self, update: Update, seconds: float) -> None:
        assert self._folder is not None
        rate = update.step_count * self._options.num_envs * self._ranks.count / seconds
        environment = update.environment_seconds / seconds
        policy = update.policy_seconds / seconds
        learning = 1 - environment - policy
        shares = [round(share, 4) for share in (environment, policy, learning)]
        means = [float(mean) for mean in np.mean(self._recent, 0)] if self._recent else ["", ""]
        row = [self._step, *means, round(rate, 1), *shares]
        self._folder.write("progress", [row])
        self._folder.write("learning", [[self._step, *update.metrics]])
        scalars = dict(zip(PROGRESS_COLUMNS[1:], row[1:], strict=True))
        scalars |= dict(zip(self._learner.metric_names, update.metrics, strict=True))
        self._folder.plot(self._step, {k: v for k, v in scalars.items() if v != ""})
        episode = f"return {means[0]:.2f}, length {means[1]:.0f}, " if self._recent else ""
        self._progress.show(
            self._step,
            f"{episode}{rate:,.0f} steps/s (environment {environment:.0%}, policy {policy:.0%}, "
            f"learning {learning:.0%})",
        )

    def _save(self) -> None:
        states = self._ranks.gather(self._learner.rank_state())
        if self._folder is not None:
            self._folder.save(
                {
                    "options": vars(self._options),
                    "step": self._step,
                    "learner": self._learner.state(),
                    "ranks": states,
                    "recent": list(self._recent),
                    "sizes": self._folder.sizes(),
                    "evaluation": self._evaluation and self._evaluation.state(),
                }
            )
