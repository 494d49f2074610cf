"""libprocgen, the engine in this process: its C ABI (clients/c/procgen.h) as ctypes."""

from __future__ import annotations

import ctypes
import os
from pathlib import Path
from typing import Any

from procgen_client.errors import FailedPreconditionError, of_code

# A path of the library, in place of the one in this package.
LIBRARY_VARIABLE = "PROCGEN_LIBRARY"

_ABI_VERSION = 1
_NAME = "libprocgen.so.1"

_Pool = ctypes.c_void_p
_Array = ctypes.c_void_p


class LevelSampler(ctypes.Structure):
    """ProcgenLevelSampler."""

    _fields_ = (
        ("struct_size", ctypes.c_size_t),
        ("level_seeds", _Array),
        ("weights", _Array),
        ("seed_count", ctypes.c_int64),
        ("rand_seed", ctypes.c_int64),
    )


class PoolOptions(ctypes.Structure):
    """ProcgenPoolOptions."""

    _fields_ = (
        ("struct_size", ctypes.c_size_t),
        ("games", ctypes.POINTER(ctypes.c_char_p)),
        ("game_count", ctypes.c_int32),
        ("env_count", ctypes.c_int32),
        ("first_env", ctypes.c_int32),
        ("total_env_count", ctypes.c_int32),
        ("distribution_mode", ctypes.c_int32),
        ("num_levels", ctypes.c_int32),
        ("start_level", ctypes.c_int32),
        ("debug_mode", ctypes.c_int32),
        ("rand_seed", ctypes.c_int64),
        ("has_rand_seed", ctypes.c_uint8),
        ("use_sequential_levels", ctypes.c_uint8),
        ("center_agent", ctypes.c_uint8),
        ("use_backgrounds", ctypes.c_uint8),
        ("use_generated_assets", ctypes.c_uint8),
        ("use_monochrome_assets", ctypes.c_uint8),
        ("restrict_themes", ctypes.c_uint8),
        ("paint_vel_info", ctypes.c_uint8),
        ("autoreset_mode", ctypes.c_int32),
        ("screen_size", ctypes.c_int32),
        ("frame_stack", ctypes.c_int32),
        ("layout", ctypes.c_int32),
        ("grayscale_obs", ctypes.c_uint8),
        ("level_sampler", ctypes.POINTER(LevelSampler)),
        ("art", ctypes.c_char_p),
        ("num_threads", ctypes.c_int32),
    )


class PoolInfo(ctypes.Structure):
    """ProcgenPoolInfo."""

    _fields_ = (
        ("struct_size", ctypes.c_size_t),
        ("env_count", ctypes.c_int32),
        ("num_threads", ctypes.c_int32),
        ("rand_seed", ctypes.c_int64),
        ("observation_rank", ctypes.c_int32),
        ("observation_shape", ctypes.c_int32 * 4),
        ("observation_bytes", ctypes.c_int64),
    )


class Reset(ctypes.Structure):
    """ProcgenReset."""

    _fields_ = (
        ("environment", ctypes.c_int32),
        ("level_seed", ctypes.c_int32),
        ("rand_seed", ctypes.c_int64),
        ("has_level_seed", ctypes.c_uint8),
        ("has_rand_seed", ctypes.c_uint8),
    )


class NextLevel(ctypes.Structure):
    """ProcgenNextLevel."""

    _fields_ = (("environment", ctypes.c_int32), ("level_seed", ctypes.c_int32))


class Step(ctypes.Structure):
    """ProcgenStep."""

    _fields_ = (
        ("struct_size", ctypes.c_size_t),
        ("first_env", ctypes.c_int32),
        ("env_count", ctypes.c_int32),
        ("actions", _Array),
        ("repeat_count", ctypes.c_int32),
        ("next_level_count", ctypes.c_int32),
        ("next_levels", ctypes.POINTER(NextLevel)),
        ("resets", ctypes.POINTER(Reset)),
        ("reset_count", ctypes.c_int32),
    )


# The arrays of ProcgenBatch, in order.
BATCH_ARRAYS = (
    "observations",
    "rewards",
    "first",
    "terminated",
    "truncated",
    "level_seeds",
    "prev_level_seeds",
    "prev_level_complete",
    "episode_returns",
    "episode_lengths",
    "fingerprints",
    "final_observations",
)


class Batch(ctypes.Structure):
    """ProcgenBatch."""

    _fields_ = (("struct_size", ctypes.c_size_t), *((name, _Array) for name in BATCH_ARRAYS))


# Arguments of the functions that return a code, by name.
_FUNCTIONS: dict[str, tuple[Any, ...]] = {
    "pool_create": (ctypes.POINTER(PoolOptions), ctypes.POINTER(_Pool)),
    "pool_info": (_Pool, ctypes.POINTER(PoolInfo)),
    "step": (_Pool, _Array, _Array),
    "reset": (_Pool, ctypes.c_int32, ctypes.c_int32, _Array, ctypes.c_int32, _Array),
    "observe": (_Pool, ctypes.c_int32, ctypes.c_int32, _Array),
    "send_step": (_Pool, _Array, _Array),
    "send_reset": (_Pool, ctypes.c_int32, ctypes.c_int32, _Array, ctypes.c_int32, _Array),
    "send_observe": (_Pool, ctypes.c_int32, ctypes.c_int32, _Array),
    "receive": (_Pool, ctypes.c_double),
    "set_level_sampler": (_Pool, ctypes.POINTER(LevelSampler)),
    "save_states": (_Pool, _Array, ctypes.c_int32, _Array, ctypes.c_size_t, _Array),
    "restore_states": (_Pool, _Array, ctypes.c_int32, _Array, _Array),
    "clone_states": (_Pool, _Array, _Array, ctypes.c_int32),
    "render": (_Pool, ctypes.c_int32, ctypes.c_int32, ctypes.c_uint8, _Array),
}


class Library:
    """The functions of the library, without their prefix ``procgen_``.

    Those that can fail return a code, which is 0 or goes to :meth:`error`.
    """

    def __init__(self, path: str | Path) -> None:
        """Loads it.

        Raises:
            OSError: There is no such file, or it is not a library.
            FailedPreconditionError: It has another version of the interface.
        """
        loaded = ctypes.CDLL(os.fspath(path))
        version = loaded.procgen_abi_version()
        if version != _ABI_VERSION:
            raise FailedPreconditionError(
                f"{path} has version {version} of its interface; this package needs {_ABI_VERSION}"
            )
        for name, arguments in _FUNCTIONS.items():
            function = getattr(loaded, f"procgen_{name}")
            function.argtypes = arguments
            function.restype = ctypes.c_int
            setattr(self, name, function)
        self.pool_options_init = loaded.procgen_pool_options_init
        self.pool_options_init.argtypes = (ctypes.POINTER(PoolOptions), ctypes.c_size_t)
        self.pool_options_init.restype = None
        self.pool_destroy = loaded.procgen_pool_destroy
        self.pool_destroy.argtypes = (_Pool,)
        self.pool_destroy.restype = None
        for name in ("version", "error_message", "catalog_json"):
            getattr(loaded, f"procgen_{name}").restype = ctypes.c_char_p
        self._error_message = loaded.procgen_error_message
        self.version: str = loaded.procgen_version().decode()
        self.catalog_json: str = loaded.procgen_catalog_json().decode()

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401 - the functions set above
        raise AttributeError(f"libprocgen has no function procgen_{name}")

    def error(self, code: int) -> Exception:
        """Returns the exception for a code that the last call of this thread returned."""
        return of_code(code, self._error_message().decode(errors="replace"))


_library: Library | None = None


def library() -> Library:
    """Returns the library; loads it on the first call.

    Raises:
        OSError: It is not installed; the message has the places that were tried.
    """
    global _library
    if _library is None:
        tried = []
        for path in _places():
            if path.exists():
                _library = Library(path)
                return _library
            tried.append(str(path))
        raise OSError(
            f"libprocgen is not installed; tried: {', '.join(tried)}. In a checkout, "
            "deploy/quickstart.sh builds it"
        )
    return _library


def _places() -> list[Path]:
    package = Path(__file__).resolve().parent
    given = os.environ.get(LIBRARY_VARIABLE)
    if given:
        return [Path(given)]
    return [package / _NAME, package.parents[2] / "build/release/lib" / _NAME]
