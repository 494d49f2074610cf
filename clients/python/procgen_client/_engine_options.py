"""Arguments of a pool in this process as structs of the library."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from procgen_client import _library
from procgen_client._requests import Reset
from procgen_client.errors import InvalidArgumentError
from procgen_client.options import LevelSampler


def pool_options(
    games: Sequence[str],
    **fields: Any,  # noqa: ANN401
) -> tuple[_library.PoolOptions, object]:
    """Returns options with defaults where no field is given, and what must live as long.

    Args:
        games: Names of games.
        **fields: Fields of ProcgenPoolOptions in clients/c/procgen.h; ``level_sampler`` is a
            LevelSampler, ``art`` a path, ``rand_seed`` an int or None.
    """
    options = _library.PoolOptions()
    _library.library().pool_options_init(ctypes.byref(options), ctypes.sizeof(options))
    names = (ctypes.c_char_p * len(games))(*(name.encode() for name in games))
    options.games, options.game_count = names, len(games)
    kept: list[object] = [names]
    for name, value in fields.items():
        if value is None:
            continue
        if name == "level_sampler":
            struct, more = sampler_struct(value)
            kept += [struct, more]
            options.level_sampler = ctypes.pointer(struct)
        elif name == "art":
            options.art = str(value).encode()
        else:
            setattr(options, name, value)
            if name == "rand_seed":
                options.has_rand_seed = 1
    return options, kept


def sampler_struct(level_sampler: LevelSampler) -> tuple[_library.LevelSampler, object]:
    """Returns a sampler as a struct, and the arrays that must live as long.

    Raises:
        InvalidArgumentError: A list has a wrong type or length. The engine checks the values.
    """
    level_seeds, weights, rand_seed = level_sampler
    seeds = np.asarray(level_seeds)
    if seeds.ndim != 1 or (seeds.size and seeds.dtype.kind not in "iu"):
        raise InvalidArgumentError(
            f"level_seeds has shape {list(seeds.shape)} and type {seeds.dtype}; it is a list of "
            "integers"
        )
    seeds = np.ascontiguousarray(seeds, np.int32)
    shares = None if weights is None else np.ascontiguousarray(weights, np.float32)
    if shares is not None and shares.shape != seeds.shape:
        raise InvalidArgumentError(
            f"weights has shape {list(shares.shape)}; it is one number for each of "
            f"{len(seeds)} level_seeds"
        )
    struct = _library.LevelSampler(
        struct_size=ctypes.sizeof(_library.LevelSampler),
        level_seeds=seeds.ctypes.data,
        weights=None if shares is None else shares.ctypes.data,
        seed_count=len(seeds),
        rand_seed=rand_seed,
    )
    return struct, (seeds, shares)


def reset_array(resets: Iterable[int | Reset]) -> ctypes.Array[_library.Reset]:
    """Returns environments (indices in the pool, or Resets) as structs."""
    structs = []
    for reset in resets:
        environment, level_seed, rand_seed = (
            reset if isinstance(reset, Reset) else Reset(int(reset))
        )
        structs.append(
            _library.Reset(
                environment=environment,
                level_seed=level_seed or 0,
                rand_seed=rand_seed or 0,
                has_level_seed=level_seed is not None,
                has_rand_seed=rand_seed is not None,
            )
        )
    return (_library.Reset * len(structs))(*structs)


def next_level_array(next_levels: Mapping[int, int]) -> ctypes.Array[_library.NextLevel]:
    """Returns level seeds by environment as structs."""
    structs = [_library.NextLevel(*level) for level in next_levels.items()]
    return (_library.NextLevel * len(structs))(*structs)


def indices_of(environments: Iterable[int]) -> np.ndarray:
    """Returns indices as the library reads them, int32 [n]."""
    return np.fromiter(environments, np.int32)
