"""Environments of a library with the C interface of clients/libenv, ours or upstream's."""

from __future__ import annotations

import ctypes
import os
from pathlib import Path

import numpy as np

DISTRIBUTION_MODES = {"easy": 0, "hard": 1, "extreme": 2, "memory": 10}
_UINT8, _INT32 = 1, 2  # libenv.h
# The defaults of upstream's Python package, except easy levels, a fixed seed and no threads.
_INTEGERS = {"num_levels": 0, "start_level": 0, "num_actions": 15, "rand_seed": 1,
             "num_threads": 0, "distribution_mode": 0, "debug_mode": 0}  # fmt: skip
_BOOLEANS = {"center_agent": True, "use_backgrounds": True, "use_sequential_levels": False,
             "use_generated_assets": False, "use_monochrome_assets": False,
             "restrict_themes": False, "paint_vel_info": False, "render_human": False}  # fmt: skip


class _Option(ctypes.Structure):
    """LibenvOption."""

    _fields_ = (
        ("name", ctypes.c_char * 128),
        ("value_type", ctypes.c_int),
        ("count", ctypes.c_int),
        ("data", ctypes.c_void_p),
    )


class _Options(ctypes.Structure):
    """LibenvOptions."""

    _fields_ = (("items", ctypes.POINTER(_Option)), ("count", ctypes.c_int))


class _Buffers(ctypes.Structure):
    """LibenvBuffers."""

    _fields_ = tuple(
        (name, ctypes.c_void_p)
        for name in ("observations", "rewards", "firsts", "infos", "actions")
    )


class LibenvEnvironments:
    """A handle of the library. `arrays` has the results of the last step, environment first."""

    def __init__(
        self, library: Path, images: Path, games: str, env_count: int = 64, **options: int
    ) -> None:
        """Creates it. `games`: names, separated by commas. `options`: by upstream's names.

        Upstream's library ends the process if an option is invalid.
        """
        unknown = options.keys() - _INTEGERS.keys() - _BOOLEANS.keys()
        if unknown:
            raise ValueError(
                f"unknown options {sorted(unknown)}, allowed: {[*_INTEGERS, *_BOOLEANS]}"
            )
        self._library = ctypes.CDLL(os.fspath(library))
        self._library.libenv_make.restype = ctypes.c_void_p
        self._library.libenv_make.argtypes = (ctypes.c_int, _Options)
        self._library.libenv_set_buffers.argtypes = (ctypes.c_void_p, ctypes.POINTER(_Buffers))
        for name in ("libenv_act", "libenv_observe", "libenv_close"):
            getattr(self._library, name).argtypes = (ctypes.c_void_p,)
        self._handle = self._make(env_count, games, images, options)
        self._actions = np.zeros(env_count, np.int32)
        self.arrays = {
            "observations": np.zeros((env_count, 64, 64, 3), np.uint8),
            "rewards": np.zeros(env_count, np.float32),
            "first": np.zeros(env_count, np.uint8),
            "prev_level_seeds": np.zeros(env_count, np.int32),
            "prev_level_complete": np.zeros(env_count, np.uint8),
            "level_seeds": np.zeros(env_count, np.int32),
        }
        if options.get("render_human"):
            self.arrays["human_views"] = np.zeros((env_count, 512, 512, 3), np.uint8)
        self._set_buffers()
        self._library.libenv_observe(self._handle)

    def _make(self, env_count: int, games: str, images: Path, options: dict[str, int]) -> int:
        strings = {"env_name": games, "resource_root": f"{images}/"}
        values = {name: (_UINT8, np.frombuffer(text.encode(), np.uint8))
                  for name, text in strings.items()}  # fmt: skip
        for name, default in _INTEGERS.items():
            values[name] = _INT32, np.array([options.get(name, default)], np.int32)
        for name, default in _BOOLEANS.items():
            values[name] = _UINT8, np.array([options.get(name, default)], np.uint8)
        items = (_Option * len(values))(
            *(_Option(name.encode(), kind, len(data), data.ctypes.data)
              for name, (kind, data) in values.items())
        )  # fmt: skip
        handle = self._library.libenv_make(env_count, _Options(items, len(values)))
        if not handle:
            raise RuntimeError("libenv_make failed; the reason is on standard error")
        return handle

    def _set_buffers(self) -> None:
        infos = [self.arrays[name] for name in
                 ("prev_level_seeds", "prev_level_complete", "level_seeds", "human_views")
                 if name in self.arrays]  # fmt: skip
        observations, infos, actions = map(
            _pointers, ([self.arrays["observations"]], infos, [self._actions])
        )
        buffers = _Buffers(
            ctypes.addressof(observations), self.arrays["rewards"].ctypes.data,
            self.arrays["first"].ctypes.data, ctypes.addressof(infos), ctypes.addressof(actions),
        )  # fmt: skip
        self._library.libenv_set_buffers(self._handle, ctypes.byref(buffers))

    def step(self, actions: np.ndarray) -> np.ndarray:
        """Steps all environments. Returns observations, which the next call overwrites."""
        self._actions[:] = actions
        self._library.libenv_act(self._handle)
        self._library.libenv_observe(self._handle)
        return self.arrays["observations"]

    def close(self) -> None:
        """Frees the handle."""
        self._library.libenv_close(self._handle)


def _pointers(members: list[np.ndarray]) -> ctypes.Array[ctypes.c_void_p]:
    """The addresses of the rows of each member of a space."""
    rows = [row.ctypes.data for member in members for row in np.split(member, len(member))]
    return (ctypes.c_void_p * len(rows))(*rows)
