"""Steps of a pool as an XLA custom call: jitted programs run them without Python."""

from __future__ import annotations

import ctypes
import functools
import os
import subprocess
import tempfile
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import numpy as np

from procgen_client.errors import FailedPreconditionError, InvalidArgumentError
from procgen_client.pool import Pool

_SOURCE = Path(__file__).with_suffix(".c")
# The folder of procgen.h: in a wheel and in a checkout.
_HEADERS = (_SOURCE.parents[1], _SOURCE.parents[3] / "c")


class XlaPool(Pool):
    """A pool that compiled programs step, until it is closed."""

    _detach: Callable[[], None] | None = None  # From compiled programs.

    def xla_handle(self) -> Any:  # noqa: ANN401 - of JAX
        """Returns the handle of the next step. The first call compiles the handler.

        Raises:
            FailedPreconditionError: There is no C compiler, or it fails.
        """
        self._target, library = _handler(self._library.path)
        if self._detach is None:
            self._address = library.procgen_xla_open(self._handle, self.env_count)
            self._detach = weakref.finalize(self, library.procgen_xla_close, self._address)
        return jax.numpy.uint32(library.procgen_xla_handle(self._address))

    def xla_step(self, results: Any, handle: Any, actions: Any) -> Any:  # noqa: ANN401
        """Returns the next handle and arrays with the shapes of `results`, after xla_handle."""
        if actions.shape != (self.env_count,) or actions.dtype.kind not in "iu":
            raise InvalidArgumentError(
                f"actions has shape {list(actions.shape)} and type {actions.dtype}; it is one "
                f"integer for each of {self.env_count} environments"
            )
        handles = jax.ShapeDtypeStruct((), np.uint32)
        call = jax.ffi.ffi_call(self._target, (handles, *results), has_side_effect=True)
        return call(handle, actions.astype(np.int32), stepper=np.int64(self._address))

    def close(self) -> None:
        """Waits for a step of a compiled program, and closes the pool."""
        if self._detach is not None:
            self._detach()
        super().close()


@functools.cache
def _handler(library: Path) -> tuple[str, ctypes.CDLL]:
    """Compiles and registers the handler of a library; returns the name of its target."""
    headers = next(folder for folder in _HEADERS if (folder / "procgen.h").exists())
    with tempfile.TemporaryDirectory() as folder:
        compiled = Path(folder) / "xla.so"
        command: list[str | Path] = [
            *(os.environ.get("CC", "cc"), "-O2", "-shared", "-fPIC", f"-I{headers}"),
            *(f"-I{jax.ffi.include_dir()}", _SOURCE, library, "-o", compiled),
        ]
        try:
            subprocess.run(command, check=True, capture_output=True, text=True)
            loaded = ctypes.CDLL(os.fspath(compiled))
        except (OSError, subprocess.CalledProcessError) as error:
            raise FailedPreconditionError(
                "xla() needs a C compiler: install cc, or name another one in CC; "
                f"{getattr(error, 'stderr', None) or error}"
            ) from error
    loaded.procgen_xla_open.argtypes = (ctypes.c_void_p, ctypes.c_int32)
    loaded.procgen_xla_open.restype = ctypes.c_void_p
    loaded.procgen_xla_close.argtypes = loaded.procgen_xla_handle.argtypes = (ctypes.c_void_p,)
    loaded.procgen_xla_handle.restype = ctypes.c_uint32
    target = f"procgen_step_{library.name}"
    handler = jax.ffi.pycapsule(loaded.procgen_xla_step)
    jax.ffi.register_ffi_target(target, handler, platform="cpu")
    return target, loaded
