"""Options of a pool, by the names of Procgen 0.10.7 ("upstream"), as messages."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Callable, Iterable, Sequence
from datetime import timedelta
from typing import Any, NamedTuple, TypedDict

import numpy as np
import numpy.typing as npt
from google.protobuf.duration_pb2 import Duration

from procgen_client._proto import pools_pb2
from procgen_client._requests import ENV_COUNT_MAX, in_range, message_of
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
DISTRIBUTION_MODES = ("easy", "hard", "extreme", "memory", "exploration")
AUTORESET_MODES = ("same_step", "next_step", "disabled")
LAYOUTS = ("hwc", "chw")
TRANSPORTS = ("auto", "stream", "shared_memory")
ENCODINGS = ("raw", "delta_zstd")
# Bounds of an observation's side, in pixels, and of its number of frames.
SCREEN_SIZE_MIN = 16
SCREEN_SIZE_MAX = 512
FRAME_STACK_MAX = 16


class EnvironmentOptions(TypedDict, total=False):
    """Upstream's options. The last word of each comment is the default, as upstream's.

    ``EnvironmentOptions`` in proto/procgen/v1/pools.proto documents each.
    """

    distribution_mode: str  # One of DISTRIBUTION_MODES; each game has some. "hard"
    num_levels: int  # Number of different levels; 0: unlimited. 0
    start_level: int  # First level seed; ignored if num_levels is 0. 0
    rand_seed: int | None  # Seeds the choice of levels. None: the server draws one. None
    use_sequential_levels: bool  # A completed level continues with the next one. False
    center_agent: bool  # The camera follows the agent; some games override it. True
    use_backgrounds: bool  # False: a black background. True
    use_generated_assets: bool  # Images are generated from random numbers. False
    use_monochrome_assets: bool  # Flat rectangles instead of art. False
    restrict_themes: bool  # One theme for each kind of object. False
    paint_vel_info: bool  # Two grey squares in the observation show the velocity. False
    debug_mode: int  # Bit mask that only coinrun reads. 0


# Bounds of the options that are integers. Upstream's are int32; rand_seed may also be unsigned.
_INTEGERS = {
    "num_levels": (0, 2**31 - 1),
    "start_level": (0, 2**31 - 1),
    "rand_seed": (-(2**31), 2**32 - 1),
    "debug_mode": (-(2**31), 2**31 - 1),
}


def environment_options(options: EnvironmentOptions) -> pools_pb2.EnvironmentOptions:
    """Returns EnvironmentOptions as a message. Warns of a start_level without num_levels.

    Args:
        options: Those that differ from upstream's defaults; check_names has checked the names.

    Raises:
        InvalidArgumentError: A value has a wrong type or is out of range. The server validates
            everything else.
    """
    given: dict[str, Any] = {
        **{"distribution_mode": "hard", "center_agent": True, "use_backgrounds": True},
        **options,
    }
    message = pools_pb2.EnvironmentOptions()
    for name, value in given.items():
        if name == "distribution_mode":
            enum = pools_pb2.DistributionMode
            message.distribution_mode = _enum_value(name, value, DISTRIBUTION_MODES, enum)
        elif name in _INTEGERS:
            if name != "rand_seed" or value is not None:
                setattr(message, name, in_range(name, value, *_INTEGERS[name]))
        elif isinstance(value, bool | np.bool_ | int) and value in (0, 1):
            setattr(message, name, bool(value))
        else:
            raise InvalidArgumentError(f"{name} is {value!r}; it is True or False")
    if message.start_level and not message.num_levels:
        warn_caller(
            f"start_level is {message.start_level}, but num_levels is 0 (unlimited), so it has no "
            "effect, as upstream: num_levels=1 plays just this level"
        )
    return message


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

    The server knows the names.
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


def observation_format(
    screen_size: int = 64,
    grayscale_obs: bool = False,
    layout: str = "hwc",
    frame_stack: int = 1,
) -> pools_pb2.ObservationFormat:
    """Returns an ObservationFormat as a message.

    Args:
        screen_size: Side of the square frame in pixels, in [SCREEN_SIZE_MIN, SCREEN_SIZE_MAX]. The
            server renders at that size.
        grayscale_obs: One channel, (77 red + 150 green + 29 blue + 128) // 256, instead of three.
        layout: Order of a frame's axes: "hwc" (height, width, channels) or "chw".
        frame_stack: Number of frames of successive steps in one observation, oldest first, in
            [1, FRAME_STACK_MAX]. More than 1 add a first axis. An episode starts with copies of its
            first frame.

    Raises:
        InvalidArgumentError: A value is out of range.
    """
    size_px = in_range("screen_size", screen_size, SCREEN_SIZE_MIN, SCREEN_SIZE_MAX)
    return message_of(
        pools_pb2.ObservationFormat,
        color=pools_pb2.COLOR_GRAYSCALE if grayscale_obs else pools_pb2.COLOR_RGB,
        layout=_enum_value("layout", layout, LAYOUTS, pools_pb2.Layout),
        size_px=size_px,
        frame_stack=in_range("frame_stack", frame_stack, 1, FRAME_STACK_MAX),
    )


class LevelSampler(NamedTuple):
    """A weighted list of levels, in place of num_levels and start_level.

    The server draws from it each time an environment needs a level that no request has chosen.
    Equal samplers draw equal levels on every server.
    """

    level_seeds: npt.ArrayLike  # int32 [n], n in [1, 1000000]; duplicates are allowed.
    weights: npt.ArrayLike | None = None  # float [n], relative, at least 0. None: uniform.
    rand_seed: int = 0  # Seeds the draws, modulo 2^32.


def level_sampler_message(level_sampler: LevelSampler) -> pools_pb2.LevelSampler:
    """Returns a sampler as a message.

    Raises:
        InvalidArgumentError: A value has a wrong type. The server validates everything else.
    """
    level_seeds, weights, rand_seed = level_sampler
    seeds = np.asarray(level_seeds)
    if seeds.ndim != 1 or (seeds.size and seeds.dtype.kind not in "iu"):
        raise InvalidArgumentError(
            f"level_seeds has shape {list(seeds.shape)} and type {seeds.dtype}; it is a list of "
            "integers"
        )
    shares = np.asarray([] if weights is None else weights, dtype=np.float32)
    if shares.ndim != 1:
        raise InvalidArgumentError(
            f"weights has shape {list(shares.shape)}; it is one number for each of level_seeds"
        )
    return message_of(
        pools_pb2.LevelSampler,
        level_seeds=seeds.tolist(),
        weights=shares.tolist(),
        rand_seed=rand_seed,
    )


def pool_spec(
    games: str | Sequence[str],
    env_count: int,
    *,
    options: pools_pb2.EnvironmentOptions,
    autoreset_mode: str = "same_step",
    first_env: int = 0,
    total_env_count: int = 0,
    observation_format: pools_pb2.ObservationFormat | None = None,
    encoding: str = "raw",
    lease_duration: float | None = None,
    level_sampler: LevelSampler | None = None,
    transport: str = "auto",
) -> pools_pb2.PoolSpec:
    """Returns the spec of a pool as a message.

    Args:
        games: A game's name, or several, which alternate over the environments.
        env_count: Number of environments.
        options: From environment_options.
        autoreset_mode: One of AUTORESET_MODES; see Client.create_pool.
        first_env: For a part of a larger pool: index of its first environment in the whole.
        total_env_count: For the same: number of environments of the whole.
        observation_format: From observation_format. None: upstream's.
        encoding: Encoding of observations, one of ENCODINGS.
        lease_duration: Lifetime without a stream, in seconds. None: the server's default (10
            minutes). 0: until it is deleted.
        level_sampler: Chooses the levels. None: the options do.
        transport: Way of the batches to the learner, one of TRANSPORTS. "auto": unset.

    Raises:
        InvalidArgumentError: `autoreset_mode`, `encoding` or `transport` is not one of the values
            above, or a number does not fit its field.
    """
    mode = _enum_value("autoreset_mode", autoreset_mode, AUTORESET_MODES, pools_pb2.AutoresetMode)
    how = pools_pb2.TRANSPORT_UNSPECIFIED
    if transport != "auto":
        how = _enum_value("transport", transport, TRANSPORTS, pools_pb2.Transport)
    code = _enum_value("encoding", encoding, ENCODINGS, pools_pb2.Encoding)
    return message_of(
        pools_pb2.PoolSpec,
        games=game_names(games),
        env_count=in_range("env_count", env_count, 1, ENV_COUNT_MAX),
        options=options,
        autoreset_mode=mode,
        first_env=in_range("first_env", first_env, 0, ENV_COUNT_MAX),
        total_env_count=in_range("total_env_count", total_env_count, 0, ENV_COUNT_MAX),
        observation_format=observation_format,
        encoding=code,
        lease_duration=None if lease_duration is None else duration(lease_duration),
        level_sampler=None if level_sampler is None else level_sampler_message(level_sampler),
        transport=how,
    )


def duration(seconds: float) -> Duration:
    """Returns seconds as a message."""
    message = Duration()
    try:
        message.FromTimedelta(timedelta(seconds=seconds))
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidArgumentError(f"a duration of {seconds} s is invalid: {error}") from error
    return message


def _enum_value(name: str, given: str, allowed: Sequence[str], enum: Any) -> Any:  # noqa: ANN401
    """Returns an enum's value, e.g. DISTRIBUTION_MODE_HARD for "hard"."""
    if not isinstance(given, str) or given not in allowed:
        raise InvalidArgumentError(f"{name} is {given!r}; it is one of {', '.join(allowed)}")
    return enum.Value(f"{name}_{given}".upper())
