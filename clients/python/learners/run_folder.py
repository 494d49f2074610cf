"""The folder of a training run: CSV files, TensorBoard events, checkpoints."""

from __future__ import annotations

import csv
import json
import os
import platform
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch

import procgen_client
from learners import checkpoint_file
from procgen_client._checkpoint import write_atomically
from procgen_client.tools.art import ART_VARIABLE

CHECKPOINT = "checkpoint.pt"


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
