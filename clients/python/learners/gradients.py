"""Gradients of a minibatch in chunks, each the work of one thread."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

import torch

# From a chunk of each tensor: the loss, summed over the chunk, and what else is to be returned.
Loss = Callable[..., tuple[torch.Tensor, torch.Tensor]]


class ChunkedGradients:
    """Computes gradients with threads that meet once a minibatch.

    Threads within operators meet thousands of times in a minibatch; where other programs use the
    cores, that takes most of the time. The gradients of chunks are added in order, so the number of
    threads changes no bit of them. A chunk that fits the caches is also faster on one thread.
    """

    def __init__(
        self, parameters: Sequence[torch.nn.Parameter], chunk_size: int, thread_count: int
    ) -> None:
        """Takes the parameters, and rows of a chunk; 0: the whole minibatch is one."""
        self._parameters = parameters
        self._chunk_size = chunk_size
        # A GPU's current device is one of each thread: there, all is done in this one.
        self._map = map if thread_count == 1 else ThreadPoolExecutor(thread_count).map

    def __call__(
        self, loss: Loss, *tensors: torch.Tensor
    ) -> tuple[list[torch.Tensor], list[torch.Tensor]]:
        """Returns the gradients of the mean loss, and what `loss` returned for each chunk."""
        row_count = len(tensors[0])

        def of_chunk(*chunk: torch.Tensor) -> tuple[Sequence[torch.Tensor], torch.Tensor]:
            loss_sum, others = loss(*chunk)
            return torch.autograd.grad(loss_sum / row_count, self._parameters), others

        size = self._chunk_size or row_count
        chunks = zip(*(tensor.split(size) for tensor in tensors), strict=True)
        results = list(self._map(lambda chunk: of_chunk(*chunk), chunks))
        gradients = list(results[0][0])
        for others, _ in results[1:]:
            torch._foreach_add_(gradients, list(others))
        return gradients, [others for _, others in results]
