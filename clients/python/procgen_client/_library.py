"""The C libraries as ctypes: libprocgen, the engine in this process (clients/c/procgen.h), and
libprocgen_remote, which also has pools on servers (clients/c/procgen_remote.h).
"""

from __future__ import annotations

import ctypes
import os
from pathlib import Path
from typing import Any

from procgen_client.errors import FailedPreconditionError, ProcgenError, of_code

# Paths of the libraries, in place of those in this package.
LIBRARY_VARIABLE = "PROCGEN_LIBRARY"
REMOTE_LIBRARY_VARIABLE = "PROCGEN_REMOTE_LIBRARY"

_ABI_VERSION = 1

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
        ("variant", ctypes.c_char_p),
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


# The fields of ProcgenObject, in order.
OBJECT_FIELDS = ("kind", "theme", "x", "y", "vx", "vy", "rx", "ry", "rotation", "health")


class Object(ctypes.Structure):
    """ProcgenObject."""

    _fields_ = tuple((name, ctypes.c_float) for name in OBJECT_FIELDS)


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


class Annotation(ctypes.Structure):
    """ProcgenAnnotation."""

    _fields_ = (
        ("name", ctypes.c_char_p),
        ("values", _Array),
        ("value_count", ctypes.c_int32),
    )


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
        ("annotations", ctypes.POINTER(Annotation)),
        ("annotation_count", ctypes.c_int32),
    )


class ConnectOptions(ctypes.Structure):
    """ProcgenConnectOptions."""

    _fields_ = (
        ("struct_size", ctypes.c_size_t),
        ("timeout_s", ctypes.c_double),
        ("call_timeout_s", ctypes.c_double),
        ("reconnect_timeout_s", ctypes.c_double),
        ("ca", ctypes.c_char_p),
        ("certificate", ctypes.c_char_p),
        ("key", ctypes.c_char_p),
        ("token", ctypes.c_char_p),
        ("token_in_plain_text", ctypes.c_uint8),
    )


class ServerPoolOptions(ctypes.Structure):
    """ProcgenServerPoolOptions."""

    _fields_ = (
        ("struct_size", ctypes.c_size_t),
        ("pool_id", ctypes.c_char_p),
        ("encoding", ctypes.c_int32),
        ("display_name", ctypes.c_char_p),
        ("labels", ctypes.POINTER(ctypes.c_char_p)),
        ("label_count", ctypes.c_int32),
    )


_Bytes = (ctypes.POINTER(ctypes.c_void_p), ctypes.POINTER(ctypes.c_size_t))
_Connection = ctypes.c_void_p
_Watch = ctypes.c_void_p
# The size of an input, and an output: its memory, size of that, number of bytes written.
_Written = (ctypes.c_size_t, _Array, ctypes.c_size_t, ctypes.POINTER(ctypes.c_size_t))
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
    "read_objects": (_Pool, ctypes.c_int32, ctypes.c_int32, ctypes.c_int32, _Array, _Array),
    "state_to_json": (ctypes.c_char_p, *_Written),
    "state_from_json": (ctypes.c_char_p, *_Written),
    "render": (_Pool, ctypes.c_int32, ctypes.c_int32, ctypes.c_uint8, _Array),
}
_REMOTE_FUNCTIONS: dict[str, tuple[Any, ...]] = {
    "connect": (ctypes.c_char_p, ctypes.POINTER(ConnectOptions), ctypes.POINTER(_Connection)),
    "connection_call": (_Connection, ctypes.c_char_p, _Array, ctypes.c_size_t, *_Bytes),
    "connection_watch": (
        *(_Connection, ctypes.c_char_p, _Array, ctypes.c_size_t, ctypes.POINTER(_Watch)),
    ),
    "watch_next": (_Watch, ctypes.c_double, *_Bytes),
    "connection_create_pool": (
        *(_Connection, ctypes.POINTER(PoolOptions), ctypes.POINTER(ServerPoolOptions)),
        ctypes.POINTER(_Pool),
    ),
}
# Those that return nothing.
_PROCEDURES: dict[str, tuple[Any, ...]] = {
    "pool_options_init": (ctypes.POINTER(PoolOptions), ctypes.c_size_t),
    "pool_destroy": (_Pool,),
}
_REMOTE_PROCEDURES: dict[str, tuple[Any, ...]] = {
    "connection_close": (_Connection,),
    "connection_destroy": (_Connection,),
    "watch_stop": (_Watch,),
    "watch_destroy": (_Watch,),
    "free": (ctypes.c_void_p,),
}


class Library:
    """The functions of a library, without their prefix ``procgen_``.

    Those that can fail return a code, which is 0 or goes to :meth:`error`.
    """

    def __init__(self, path: str | Path, *, is_remote: bool = False) -> None:
        """Loads it.

        Raises:
            OSError: There is no such file, or it is not a library.
            FailedPreconditionError: It has another version of the interface.
        """
        loaded = ctypes.CDLL(os.fspath(path))
        self.path = Path(path)
        version = loaded.procgen_abi_version()
        if version != _ABI_VERSION:
            raise FailedPreconditionError(
                f"{path} has version {version} of its interface; this package needs {_ABI_VERSION}"
            )
        functions = _FUNCTIONS | (_REMOTE_FUNCTIONS if is_remote else {})
        procedures = _PROCEDURES | (_REMOTE_PROCEDURES if is_remote else {})
        for name, arguments in {**functions, **procedures}.items():
            function = getattr(loaded, f"procgen_{name}")
            function.argtypes = arguments
            function.restype = ctypes.c_int if name in functions else None
            setattr(self, name, function)
        for name in ("version", "error_message", "catalog_json"):
            getattr(loaded, f"procgen_{name}").restype = ctypes.c_char_p
        self.unanswered_count = loaded.procgen_unanswered_count
        self.unanswered_count.argtypes = (_Pool,)
        if is_remote:
            loaded.procgen_pool_name.argtypes = (_Pool,)
            loaded.procgen_pool_name.restype = ctypes.c_char_p
            self.pool_name = loaded.procgen_pool_name
        self._error_message = loaded.procgen_error_message
        self.version: str = loaded.procgen_version().decode()
        self.catalog_json: str = loaded.procgen_catalog_json().decode()

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401 - the functions set above
        """Fails: the functions are attributes."""
        raise AttributeError(f"libprocgen has no function procgen_{name}")

    def error(self, code: int) -> ProcgenError:
        """Returns the exception for a code that the last call of this thread returned."""
        return of_code(code, self._error_message().decode(errors="replace"))

    def check(self, code: int) -> None:
        """Raises the error of a code that the last call of this thread returned, unless it is 0."""
        if code:
            raise self.error(code)


_library: Library | None = None
_remote_library: Library | None = None


def library() -> Library:
    """Returns libprocgen; loads it on the first call.

    Raises:
        OSError: It is not installed; the message has the places that were tried.
    """
    global _library
    if _library is None:
        _library = Library(_found("libprocgen", LIBRARY_VARIABLE, "build_wheel.sh"))
    return _library


def remote_library() -> Library:
    """Returns libprocgen_remote; loads it on the first call. Errors as :func:`library`."""
    global _remote_library
    if _remote_library is None:
        path = _found("libprocgen_remote", REMOTE_LIBRARY_VARIABLE, "build_wheel.sh --remote")
        _remote_library = Library(path, is_remote=True)
    return _remote_library


def _found(name: str, variable: str, wheel: str) -> Path:
    """Returns the path in a variable, else that beside this package or in its checkout's build."""
    package = Path(__file__).resolve().parent
    file = f"{name}.so.1"
    given = os.environ.get(variable)
    places = (
        [Path(given)]
        if given
        else [package / file, (package / "../../../build/release/lib" / file).resolve()]
    )
    for place in places:
        if place.exists():
            return place
    raise OSError(
        f"{name} is not installed; tried: {', '.join(map(str, places))}. The wheel of "
        f"clients/python/{wheel} contains it; in a checkout, deploy/quickstart.sh builds it"
    )
