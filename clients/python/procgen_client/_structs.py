"""Arguments of a pool as structs of the C interface (clients/c/procgen.h)."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from procgen_client import _library
from procgen_client._requests import LEVEL_SEEDS, Reset, in_range
from procgen_client.errors import InvalidArgumentError
from procgen_client.options import LevelSampler

_INT32 = (-(2**31), 2**31 - 1)
_RAND_SEEDS = (-(2**31), 2**32 - 1)


def pool_options(
    library: Any,  # noqa: ANN401 - _library.Library, or one like it
    games: Sequence[str],
    env_count: int,
    options: Mapping[str, Any],
    art: str | None,
) -> tuple[_library.PoolOptions, object]:
    """Returns the options of a pool, and what must live as long.

    Args:
        library: Gives the defaults.
        games: Names of games.
        env_count: Number of environments.
        options: From options.checked_options.
        art: Folder of upstream's images; None: the built-in art.
    """
    struct = _library.PoolOptions()
    library.pool_options_init(ctypes.byref(struct), ctypes.sizeof(struct))
    names = (ctypes.c_char_p * len(games))(*(name.encode() for name in games))
    struct.games, struct.game_count, struct.env_count = names, len(games), env_count
    struct.art = None if art is None else art.encode()
    kept: list[object] = [names]
    for name, value in options.items():
        if name == "level_sampler":
            sampler, arrays = level_sampler(value)
            kept += [sampler, arrays]
            struct.level_sampler = ctypes.pointer(sampler)
        elif name not in ("encoding", "pool_id", "name", "labels"):
            setattr(struct, name, value)
    struct.has_rand_seed = "rand_seed" in options
    return struct, kept


def level_sampler(given: LevelSampler) -> tuple[_library.LevelSampler, object]:
    """Returns a sampler, and the arrays that must live as long.

    Raises:
        InvalidArgumentError: A list has a wrong type or length. The engine checks the values.
    """
    level_seeds, weights, rand_seed = given
    seeds = np.asarray(level_seeds)
    if seeds.ndim != 1 or (seeds.size and seeds.dtype.kind not in "iu"):
        raise InvalidArgumentError(
            f"level_seeds has shape {list(seeds.shape)} and type {seeds.dtype}; it is a list of "
            "integers"
        )
    for wrong in seeds[(seeds < _INT32[0]) | (seeds > _INT32[1])][:1]:
        raise InvalidArgumentError(f"level_seeds contains {wrong}; they are in {list(_INT32)}")
    seeds = np.ascontiguousarray(seeds, np.int32)
    shares = None if weights is None else np.ascontiguousarray(weights, np.float32)
    if shares is not None and shares.shape != seeds.shape:
        raise InvalidArgumentError(
            f"weights has shape {list(shares.shape)}; it is one number for each of {len(seeds)} "
            "level_seeds"
        )
    struct = _library.LevelSampler(
        struct_size=ctypes.sizeof(_library.LevelSampler),
        level_seeds=seeds.ctypes.data,
        weights=None if shares is None else shares.ctypes.data,
        seed_count=len(seeds),
        rand_seed=in_range("rand_seed", rand_seed, -(2**63), 2**63 - 1),
    )
    return struct, (seeds, shares)


def resets(given: Iterable[int | Reset]) -> ctypes.Array[_library.Reset]:
    """Returns environments (indices in the pool, or Resets) that start new episodes."""
    structs = []
    for each in given:
        reset = each if isinstance(each, Reset) else Reset(each)
        struct = _library.Reset(environment=in_range("environment", reset.environment, *_INT32))
        if reset.level_seed is not None:
            struct.level_seed = in_range("level_seed", reset.level_seed, *LEVEL_SEEDS)
            struct.has_level_seed = 1
        if reset.rand_seed is not None:
            struct.rand_seed = in_range("rand_seed", reset.rand_seed, *_RAND_SEEDS)
            struct.has_rand_seed = 1
        structs.append(struct)
    return (_library.Reset * len(structs))(*structs)


def next_levels(given: Mapping[int, int]) -> ctypes.Array[_library.NextLevel]:
    """Returns level seeds by environment."""
    structs = [
        _library.NextLevel(
            in_range("environment", environment, *_INT32),
            in_range("level_seed", level_seed, *LEVEL_SEEDS),
        )
        for environment, level_seed in given.items()
    ]
    return (_library.NextLevel * len(structs))(*structs)


def viewer_annotations(
    given: Mapping[str, npt.ArrayLike], env_count: int
) -> tuple[ctypes.Array[_library.Annotation], object]:
    """Returns annotations of `env_count` environments, and the arrays that must live as long.

    Raises:
        InvalidArgumentError: Not one number, or one row of numbers, for each environment.
    """
    structs, kept = [], []
    for name, each in given.items():
        try:
            values = np.asarray(each)
        except ValueError as error:
            raise InvalidArgumentError(f"annotations[{name!r}] is no array: {error}") from error
        if values.ndim not in (1, 2) or len(values) != env_count or values.dtype.kind not in "biuf":
            raise InvalidArgumentError(
                f"annotations[{name!r}] has shape {list(values.shape)} and type {values.dtype}; it "
                f"has one number, or one row of numbers, for each of {env_count} environments"
            )
        values = np.ascontiguousarray(values, np.float32)
        kept.append(values)
        structs.append(
            _library.Annotation(
                name=name.encode(),
                values=values.ctypes.data,
                value_count=values.size // env_count,
            )
        )
    return (_library.Annotation * len(structs))(*structs), kept


def indices(given: Iterable[int]) -> np.ndarray:
    """Returns indices of environments, int32 [n]."""
    return np.array([in_range("environment", index, *_INT32) for index in given], np.int32)
