"""Options of a pool, by the names of Procgen 0.10.7 ("upstream")."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, TypedDict

import numpy as np
import numpy.typing as npt

from procgen_client._requests import in_range
from procgen_client._warnings import warn_caller
from procgen_client.errors import InvalidArgumentError, UnknownOptionError

GAMES = (
    "bigfish",
    "bossfight",
    "caveflyer",
    "chaser",
    "climber",
    "coinrun",
    "dodgeball",
    "fruitbot",
    "heist",
    "jumper",
    "leaper",
    "maze",
    "miner",
    "ninja",
    "plunder",
    "starpilot",
)
# Options that are one of several words, with the numbers of clients/c/procgen.h.
DISTRIBUTION_MODES = {"easy": 0, "hard": 1, "extreme": 2, "memory": 10, "exploration": 20}
AUTORESET_MODES = {"same_step": 0, "next_step": 1, "disabled": 2}
LAYOUTS = {"hwc": 0, "chw": 1}
ENCODINGS = {"raw": 0, "delta_zstd": 1}
_WORDS: dict[str, Mapping[str, int]] = {
    "distribution_mode": DISTRIBUTION_MODES,
    "autoreset_mode": AUTORESET_MODES,
    "layout": LAYOUTS,
    "encoding": ENCODINGS,
}


class LevelSampler(NamedTuple):
    """A weighted list of levels, in place of num_levels and start_level.

    A pool draws from it each time an environment needs a level that no request has chosen. Equal
    samplers draw equal levels everywhere.
    """

    level_seeds: npt.ArrayLike  # int32 [n], n in [1, 1000000]; duplicates are allowed.
    weights: npt.ArrayLike | None = None  # float [n], relative, at least 0. None: uniform.
    rand_seed: int = 0  # Seeds the draws, modulo 2^32.


class EnvironmentOptions(TypedDict, total=False):
    """Upstream's options. The last word of each comment is the default, as upstream's."""

    distribution_mode: str  # One of DISTRIBUTION_MODES; each game has some. "hard"
    num_levels: int  # Number of different levels; 0: unlimited. 0
    start_level: int  # First level seed; ignored if num_levels is 0. 0
    rand_seed: int | None  # Seeds the choice of levels. None: drawn. None
    use_sequential_levels: bool  # A completed level continues with the next one. False
    center_agent: bool  # The camera follows the agent; some games override it. True
    use_backgrounds: bool  # False: a black background. True
    use_generated_assets: bool  # Images are generated from random numbers. False
    use_monochrome_assets: bool  # Flat rectangles instead of art. False
    restrict_themes: bool  # One theme for each kind of object. False
    paint_vel_info: bool  # Two grey squares in the observation show the velocity. False
    debug_mode: int  # Bit mask that only coinrun reads. 0


class PoolOptions(EnvironmentOptions, total=False):
    """Options of any pool. The last word of each comment is the default."""

    # A variant of the game, of those in the catalog: its levels differ from upstream's by one
    # change, such as the place of the coin, or "gravity=0.1". None: upstream's. None
    variant: str | None
    screen_size: int  # Side of the square frame in pixels, in [16, 512]. 64
    grayscale_obs: bool  # One channel: (77 red + 150 green + 29 blue + 128) // 256. False
    layout: str  # Order of a frame's axes: "hwc" (height, width, channels) or "chw". "hwc"
    # Number of frames of successive steps in one observation, oldest first, in [1, 16]. More than 1
    # add a first axis. An episode starts with copies of its first frame. 1
    frame_stack: int
    level_sampler: LevelSampler | None  # Chooses the levels. None: the options above do. None
    # The pool is a slice of a larger set: index of its first environment there, and number of
    # environments of the whole (0: up to this pool's last).
    first_env: int  # 0
    total_env_count: int  # 0
    # In this process: threads that step beside the caller, in [0, 1024]. None: one for each further
    # core that the process may use. Ignored on a server. None
    num_threads: int | None
    # On a server: how observations are sent, "raw", or "delta_zstd" for slow networks; and the last
    # part of the pool's name. Ignored in this process.
    encoding: str  # "raw"
    pool_id: str  # ""
    # On a server: for people, in pages and lists: a name, and labels such as {"seed": "3"}. Ignored
    # in this process.
    name: str  # ""
    labels: Mapping[str, str]  # {}


# Bounds of the options that are integers. Upstream's are int32; rand_seed may also be unsigned.
_INTEGERS = {
    "num_levels": (0, 2**31 - 1),
    "start_level": (0, 2**31 - 1),
    "rand_seed": (-(2**31), 2**32 - 1),
    "debug_mode": (-(2**31), 2**31 - 1),
    "screen_size": (16, 512),
    "frame_stack": (1, 16),
    "first_env": (0, 2**31 - 1),
    "total_env_count": (0, 2**31 - 1),
    "num_threads": (0, 1024),
}
_BOOLEANS = frozenset(
    name
    for name, of in PoolOptions.__annotations__.items()
    if "bool" in str(getattr(of, "__forward_arg__", of))
)
# None means the default.
_OPTIONAL = frozenset({"rand_seed", "num_threads", "level_sampler", "variant"})


def checked_options(options: Mapping[str, Any]) -> dict[str, Any]:
    """Returns options of PoolOptions, and "autoreset_mode", as numbers of the C interface.

    Those that are None are left out; so is nothing else. Warns of a start_level without num_levels.

    Raises:
        InvalidArgumentError: A value has a wrong type or is out of range. The engine validates
            whether a game has it.
    """
    checked: dict[str, Any] = {}
    for name, value in options.items():
        if value is None and name in _OPTIONAL:
            continue
        if name in _WORDS:
            checked[name] = _number_of(name, value, _WORDS[name])
        elif name in _INTEGERS:
            checked[name] = in_range(name, value, *_INTEGERS[name])
        elif name in _BOOLEANS:
            if not isinstance(value, (bool, np.bool_, int)) or value not in (0, 1):
                raise InvalidArgumentError(f"{name} is {value!r}; it is True or False")
            checked[name] = int(value)
        elif name == "name":
            checked[name] = text("name", value)
        elif name == "variant":
            checked[name] = text("variant", value).encode()
        elif name == "labels":
            checked[name] = _labels(value)
        else:
            checked[name] = value
    if checked.get("start_level") and not checked.get("num_levels"):
        warn_caller(
            f"start_level is {checked['start_level']}, but num_levels is 0 (unlimited), so it has "
            "no effect, as upstream: num_levels=1 plays just this level"
        )
    return checked


def check_names(owner: str, given: Iterable[str], allowed: Iterable[str]) -> None:
    """Raises UnknownOptionError unless each name is allowed; `owner` is what has these options."""
    names = sorted(allowed)
    for name in given:
        if name not in names:
            nearest = difflib.get_close_matches(str(name), names, 1)
            hint = f" (did you mean {nearest[0]!r}?)" if nearest else ""
            raise UnknownOptionError(
                f"{owner} has no option {name!r}{hint}; its options are {', '.join(names)}"
            )


def keywords_of(*functions: Callable[..., object]) -> set[str]:
    """Returns the names of all arguments of functions that can be given by name, except self."""
    return {
        name
        for function in functions
        for name, parameter in inspect.signature(function).parameters.items()
        if parameter.kind in (parameter.POSITIONAL_OR_KEYWORD, parameter.KEYWORD_ONLY)
    } - {"self"}


def game_names(games: str | Sequence[str]) -> list[str]:
    """Returns a list of games; raises InvalidArgumentError unless `games` is text or a list of it.

    The engine knows the names.
    """
    try:
        names = [games] if isinstance(games, str) else list(games)
    except TypeError:
        names = []
    if not names or not all(isinstance(name, str) for name in names):
        raise InvalidArgumentError(
            f"games is {games!r}; it is the name of a game, or a list of names"
        )
    return names


def text(name: str, given: object) -> str:
    """Returns a text; raises InvalidArgumentError unless it is one without NUL."""
    if not isinstance(given, str) or "\0" in given:
        raise InvalidArgumentError(f"{name} is {given!r}; it is text without NUL")
    return given


def _labels(given: object) -> dict[str, str]:
    if not isinstance(given, Mapping):
        raise InvalidArgumentError(f"labels is {given!r}; it maps text to text")
    labels = {}
    for key, value in given.items():
        if "=" in text("a key of labels", key):
            raise InvalidArgumentError(f"labels has the key {key!r}; keys have no '='")
        labels[key] = text(f"labels[{key!r}]", value)
    return labels


def _number_of(name: str, given: object, allowed: Mapping[str, int]) -> int:
    if not isinstance(given, str) or given not in allowed:
        raise InvalidArgumentError(f"{name} is {given!r}; it is one of {', '.join(allowed)}")
    return allowed[given]
