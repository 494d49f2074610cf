"""Gradients of a minibatch in chunks, each computed by one thread."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

import torch

# From a chunk of each tensor to the loss, summed over the chunk, and further results.
Loss = Callable[..., tuple[torch.Tensor, torch.Tensor]]


class ChunkedGradients:
    """Computes gradients with threads that synchronise once per minibatch.

    Threads within operators synchronise thousands of times per minibatch, which takes most of the
    time on busy cores. Gradients of chunks are added in order, so the result does not depend on the
    number of threads. A chunk that fits the caches is also faster on one thread.
    """

    def __init__(
        self, parameters: Sequence[torch.nn.Parameter], chunk_size: int, thread_count: int
    ) -> None:
        """Takes the parameters and the rows per chunk; 0: the whole minibatch."""
        self._parameters = parameters
        self._chunk_size = chunk_size
        # CUDA's current device is per thread, so a GPU uses the calling thread only.
        self._map = map if thread_count == 1 else ThreadPoolExecutor(thread_count).map

    def __call__(
        self, loss: Loss, *tensors: torch.Tensor
    ) -> tuple[list[torch.Tensor], list[torch.Tensor]]:
        """Returns the gradients of the mean loss, and the further results of each chunk."""
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
        # Fused optimisers require the layout of the parameter, which backward need not keep.
        for i, parameter in enumerate(self._parameters):
            if gradients[i].stride() != parameter.stride():
                gradients[i] = torch.empty_like(parameter).copy_(gradients[i])
        return gradients, [others for _, others in results]
