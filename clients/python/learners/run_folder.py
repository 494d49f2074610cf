"""The folder of a training run: CSV files, TensorBoard events, checkpoints, a progress bar."""

from __future__ import annotations

import csv
import json
import os
import platform
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any

import numpy as np
import torch

import procgen_client
from learners import checkpoint_file
from procgen_client._checkpoint import write_atomically
from procgen_client.tools.art import ART_VARIABLE

CHECKPOINT = "checkpoint.pt"
_BAR_WIDTH = 20
# Time between two lines of progress if the output is not a terminal, in seconds.
_LINE_INTERVAL = 30.0


class Table:
    """A CSV file that can be truncated to its size at a checkpoint."""

    def __init__(self, path: Path, columns: Sequence[str], size: int | None) -> None:
        """Opens the file.

        Args:
            path: Path of the file.
            columns: Names of its columns.
            size: Size to truncate it to, in bytes. None: a new file.
        """
        self._file = open(path, "w" if size is None else "r+", newline="")
        self._writer = csv.writer(self._file, lineterminator="\n")
        if size is None:
            self._writer.writerow(columns)
        else:
            self._file.truncate(size)
            self._file.seek(0, os.SEEK_END)

    def write(self, rows: Sequence[Sequence[Any]]) -> None:
        """Appends rows and flushes."""
        self._writer.writerows(rows)
        self._file.flush()

    def size(self) -> int:
        """Returns the size in bytes."""
        return self._file.tell()

    def close(self) -> None:
        """Closes the file."""
        self._file.close()


class RunFolder:
    """The files of a run, which continue from the last checkpoint."""

    def __init__(
        self,
        path: Path,
        tables: dict[str, Sequence[str]],
        sizes: dict[str, int] | None,
        options: dict[str, Any],
    ) -> None:
        """Opens the folder.

        Args:
            path: The folder; created if it does not exist.
            tables: Columns of each CSV file, by its name without suffix.
            sizes: Sizes of the files at the checkpoint. None: a new run.
            options: Of the run; they are written to run.json, with the versions of programs.
        """
        self._path = path
        path.mkdir(parents=True, exist_ok=True)
        self._tables = {
            name: Table(path / f"{name}.csv", columns, sizes and sizes[name])
            for name, columns in tables.items()
        }
        described = json.dumps(description(options), indent=1, default=str)
        (path / "run.json").write_text(described + "\n")
        self._events = _event_writer(path)
        self._wandb = _wandb_run(path, options)

    def write(self, table: str, rows: Sequence[Sequence[Any]]) -> None:
        """Appends rows to a CSV file."""
        self._tables[table].write(rows)

    def plot(self, step: int, values: dict[str, float]) -> None:
        """Adds scalars to TensorBoard's events, if it is installed, and to Weights & Biases."""
        if self._events is not None:
            for name, value in values.items():
                self._events.add_scalar(name, value, step)
        if self._wandb is not None:
            self._wandb.log(values, step=step)

    def sizes(self) -> dict[str, int]:
        """Returns the sizes of the CSV files, for a checkpoint."""
        return {name: table.size() for name, table in self._tables.items()}

    def save(self, checkpoint: dict[str, Any]) -> None:
        """Replaces the checkpoint atomically."""
        write_atomically(
            self._path / CHECKPOINT, lambda file: checkpoint_file.save(file, checkpoint)
        )

    def close(self) -> None:
        """Closes all files."""
        for table in self._tables.values():
            table.close()
        if self._events is not None:
            self._events.close()
        if self._wandb is not None:
            self._wandb.finish()


def _event_writer(path: Path) -> Any:  # noqa: ANN401 - its type is TensorBoard's
    try:
        from torch.utils.tensorboard import SummaryWriter
    except ImportError:
        return None
    return SummaryWriter(str(path))


def _wandb_run(path: Path, options: dict[str, Any]) -> Any:  # noqa: ANN401 - its type is wandb's
    if not options.get("wandb"):
        return None
    try:
        import wandb
    except ImportError as error:
        raise SystemExit(f"--wandb needs the package wandb: {error}") from None
    name = path.resolve().name
    return wandb.init(
        project=options["wandb"], id=name, resume="allow", config=options, dir=str(path)
    )


def description(options: dict[str, Any]) -> dict[str, Any]:
    """Returns options, and what else decides the results: revision, versions, device, art."""
    git = ["git", "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        found = subprocess.run(git, cwd=Path(__file__).parent, capture_output=True, check=True)
        revision = found.stdout.decode().strip()
    except (OSError, subprocess.CalledProcessError):
        revision = None
    on_gpu = str(options["device"]).startswith("cuda")
    return {
        "options": options,
        "git_revision": revision,
        "versions": {
            "python": platform.python_version(),
            "torch": torch.__version__,
            "numpy": np.__version__,
            "procgen_client": procgen_client.__version__,
        },
        "device": torch.cuda.get_device_name() if on_gpu else platform.machine(),
        "art": os.environ.get(ART_VARIABLE, ""),
    }


class ProgressLine:
    """Prints progress and remaining time: on a terminal one line that is overwritten.

    Otherwise a line every _LINE_INTERVAL seconds.
    """

    def __init__(self, name: str, total_steps: int, stream: IO[str] = sys.stderr) -> None:
        """Takes the run's name and number of steps."""
        self._name = name
        self._total_steps = total_steps
        self._stream = stream
        self._begin: tuple[float, int] | None = None
        self._last_line = -_LINE_INTERVAL

    def show(self, step: int, text: str) -> None:
        """Prints the progress, followed by `text`."""
        now = time.monotonic()
        if self._begin is None:
            self._begin = (now, step)
        is_last = step >= self._total_steps
        if self._stream.isatty():
            end = "\n" if is_last else ""
            self._stream.write(f"\r\033[K{self._line(now, step, text)}{end}")
        elif is_last or now - self._last_line >= _LINE_INTERVAL:
            self._last_line = now
            self._stream.write(self._line(now, step, text) + "\n")
        self._stream.flush()

    def _line(self, now: float, step: int, text: str) -> str:
        assert self._begin is not None
        share = min(1.0, step / self._total_steps)
        bar = ("#" * round(share * _BAR_WIDTH)).ljust(_BAR_WIDTH, ".")
        done = step - self._begin[1]
        left = "?"
        if done > 0:
            left = duration((now - self._begin[0]) * (self._total_steps - step) / done)
        of = f"{step:,} of {self._total_steps:,} steps"
        return f"{self._name} [{bar}] {share:4.0%} {of}, {text}, {left} left"


def duration(seconds: float) -> str:
    """Returns e.g. ``1:02:03``."""
    minutes, second = divmod(max(0, round(seconds)), 60)
    hours, minute = divmod(minutes, 60)
    return f"{hours}:{minute:02}:{second:02}"
