"""The processes of a training run, started by torchrun."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import torch
import torch.distributed as dist


class Ranks:
    """Communication between the ranks, which share parameters and have separate environments.

    Without torchrun this process is the only rank.

    Attributes:
        rank: Index of this rank.
        count: Number of ranks.
    """

    def __init__(self, backend: str) -> None:
        """Joins the process group; `backend`: "nccl" on GPUs, else "gloo"."""
        self.rank = int(os.environ.get("RANK", 0))
        self.count = int(os.environ.get("WORLD_SIZE", 1))
        if self.count > 1:
            dist.init_process_group(backend)
            self._host_group = dist.new_group(backend="gloo")  # For data on the host.

    def close(self) -> None:
        """Leaves the process group: its threads must end before the interpreter does."""
        if self.count > 1:
            dist.destroy_process_group()

    def average(self, gradients: Sequence[torch.Tensor]) -> None:
        """Replaces gradients by their means over all ranks."""
        if self.count == 1:
            return
        flat = torch.cat([gradient.flatten() for gradient in gradients])
        dist.all_reduce(flat)
        flat /= self.count
        parts = flat.split([gradient.numel() for gradient in gradients])
        for gradient, part in zip(gradients, parts, strict=True):
            gradient.copy_(part.view_as(gradient))

    def gather(self, value: Any) -> list[Any]:  # noqa: ANN401
        """Returns the values of all ranks on rank 0, and an empty list on the others."""
        if self.count == 1:
            return [value]
        values = [None] * self.count if self.rank == 0 else None
        dist.gather_object(value, values, group=self._host_group)
        return values or []

    def largest(self, value: int) -> int:
        """Returns the maximum over all ranks, on each rank."""
        if self.count == 1:
            return value
        tensor = torch.tensor(value)
        dist.all_reduce(tensor, dist.ReduceOp.MAX, group=self._host_group)
        return int(tensor)
