"""Settings of PyTorch on CPUs: one thread per operator, and freed memory is kept."""

from __future__ import annotations

import ctypes

import torch

# Parameters of mallopt: the sizes in bytes above which an allocation is mapped separately and the
# free end of the heap is returned, and the number of heaps. The heaps of other threads are too
# small for large tensors.
_M_MMAP_THRESHOLD, _M_TRIM_THRESHOLD, _M_ARENA_MAX = -3, -1, -8


def use_one_thread() -> None:
    """Computes each operator on the calling thread.

    ChunkedGradients runs operators on several threads. The sums within an operator then do not
    depend on the number of threads.
    """
    torch.set_num_threads(1)
    for path in _loaded_libraries("blas"):
        # PyTorch does not pass its number of threads on to OpenBLAS.
        set_num_threads = getattr(ctypes.CDLL(path), "openblas_set_num_threads", None)
        if set_num_threads is not None:
            set_num_threads(1)


def keep_freed_memory() -> None:
    """Lets glibc keep freed memory: mapping and clearing it took up to half of an update."""
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError):
        return  # The C library is not glibc.
    mallopt(_M_ARENA_MAX, 1)
    mallopt(_M_MMAP_THRESHOLD, 1 << 30)
    mallopt(_M_TRIM_THRESHOLD, (1 << 31) - 1)


def _loaded_libraries(name: str) -> set[str]:
    """Returns the paths of loaded shared libraries whose file name contains `name`."""
    try:
        with open("/proc/self/maps") as maps:
            paths = {line.split(maxsplit=5)[-1].strip() for line in maps}
    except OSError:
        return set()
    return {path for path in paths if ".so" in path and name in path.rpartition("/")[2]}
