"""Arrays and tensors of callers, into which observations are written."""

from __future__ import annotations

import numpy as np

from procgen_client.errors import InvalidArgumentError


def writable_view(out: object, shape: tuple[int, ...]) -> np.ndarray:
    """Returns a view of `out`; writes to the view change `out`.

    Args:
        out: A numpy array; or an object that numpy views without a copy: a torch tensor on the
            CPU, also in pinned memory, or a buffer.
        shape: Its shape.

    Raises:
        InvalidArgumentError: `out` is another object, has another shape or element type, or is
            read-only or not C-contiguous.
    """
    view = out if isinstance(out, np.ndarray) else _view_of(out)
    wrong = ""
    if view.dtype != np.uint8:
        wrong = f"has type {view.dtype}"
    elif view.shape != shape:
        wrong = f"has shape {list(view.shape)}"
    elif not view.flags.c_contiguous:
        wrong = "is not C-contiguous"
    elif not view.flags.writeable:
        wrong = "is read-only"
    if wrong:
        raise InvalidArgumentError(
            f"out {wrong}; it is a writable, C-contiguous uint8 array of shape {list(shape)}"
        )
    return view


def _view_of(out: object) -> np.ndarray:
    try:
        view, again = np.asarray(out), np.asarray(out)
    except (TypeError, ValueError, RuntimeError):
        pass
    else:
        # Views of the same memory; two copies would have two addresses.
        if view.nbytes and view.ctypes.data == again.ctypes.data:
            return view
    raise InvalidArgumentError(
        f"out is {type(out).__name__}; it is a numpy array, a tensor on the CPU or a buffer"
    )
