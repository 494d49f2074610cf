"""A pool of libprocgen for benchmarks: one file of the library, fixed memory, random actions."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np

from procgen_client import _library
from procgen_client.batch import BatchStruct

_MODES = {"easy": 0, "hard": 1, "extreme": 2, "memory": 10}


class LibraryPool:
    """Environments that are stepped and observed, with all arrays of a batch."""

    def __init__(
        self,
        library: Path,
        game: str,
        mode: str,
        env_count: int,
        num_threads: int,
        art: Path | None = None,
    ) -> None:
        """Creates it. `num_threads`: beside the caller; -1: one a further core."""
        self._library = _library.Library(library)
        options = _library.PoolOptions()
        self._library.pool_options_init(ctypes.byref(options), ctypes.sizeof(options))
        names = (ctypes.c_char_p * 1)(game.encode())
        options.games, options.game_count, options.env_count = names, 1, env_count
        options.distribution_mode = _MODES[mode]
        options.rand_seed, options.has_rand_seed = 1, 1
        options.num_threads = num_threads
        if art is not None:
            options.art = str(art).encode()
        self._pool = ctypes.c_void_p()
        self._check(self._library.pool_create(ctypes.byref(options), ctypes.byref(self._pool)))
        self._actions = np.zeros(env_count, np.int32)
        self._observations = np.zeros((env_count, 64, 64, 3), np.uint8)
        self._arrays = {
            "observations": self._observations,
            "rewards": np.zeros(env_count, np.float32),
            "first": np.zeros(env_count, np.uint8),
            "level_seeds": np.zeros(env_count, np.int32),
            "prev_level_seeds": np.zeros(env_count, np.int32),
            "prev_level_complete": np.zeros(env_count, np.uint8),
        }
        self._batch = BatchStruct(ctypes.sizeof(BatchStruct))
        for name, array in self._arrays.items():
            setattr(self._batch, name, array.ctypes.data)
        self._step = _library.Step(ctypes.sizeof(_library.Step))
        self._step.env_count, self._step.actions = env_count, self._actions.ctypes.data
        self._arguments = (self._pool, ctypes.addressof(self._step), ctypes.addressof(self._batch))

    def step(self, actions: np.ndarray) -> np.ndarray:
        """Steps all environments. Returns memory that the next call overwrites."""
        self._actions[:] = actions
        self._check(self._library.step(*self._arguments))
        return self._observations

    def _check(self, code: int) -> None:
        if code:
            raise self._library.error(code)
