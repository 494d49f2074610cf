"""How PyTorch uses a CPU: one thread in each operator, and memory that is kept."""

from __future__ import annotations

import ctypes

import torch

# Parameters of mallopt, in bytes: above the first, memory is mapped and unmapped for each tensor;
# above the second, what is free at the heap's end is given back. The third is a number of heaps:
# those of threads besides the main one are too small for both.
_M_MMAP_THRESHOLD, _M_TRIM_THRESHOLD, _M_ARENA_MAX = -3, -1, -8


def use_one_thread() -> None:
    """Has each operator computed by the thread that calls it.

    ChunkedGradients has threads around operators. The sums in an operator are then the same,
    however many threads there are.
    """
    torch.set_num_threads(1)
    for path in _loaded_libraries("blas"):
        # PyTorch does not pass its number of threads on to OpenBLAS.
        set_num_threads = getattr(ctypes.CDLL(path), "openblas_set_num_threads", None)
        if set_num_threads is not None:
            set_num_threads(1)


def keep_freed_memory() -> None:
    """Has glibc keep what tensors free: to map and clear it again took up to half of an update."""
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError):
        return  # Another C library.
    mallopt(_M_ARENA_MAX, 1)
    mallopt(_M_MMAP_THRESHOLD, 1 << 30)
    mallopt(_M_TRIM_THRESHOLD, (1 << 31) - 1)


def _loaded_libraries(name: str) -> set[str]:
    """Returns the paths of this process's shared libraries whose file's name has `name` in it."""
    try:
        with open("/proc/self/maps") as maps:
            paths = {line.split(maxsplit=5)[-1].strip() for line in maps}
    except OSError:
        return set()
    return {path for path in paths if ".so" in path and name in path.rpartition("/")[2]}
