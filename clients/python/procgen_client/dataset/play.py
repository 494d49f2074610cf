"""Plays recorded actions: gives their rewards, ends and levels again, and draws the frames."""

from __future__ import annotations

import dataclasses
import os
import zlib
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from procgen_client import _library
from procgen_client._place import SERVER_VARIABLE
from procgen_client._requests import ACTION_COUNT, ACTION_MIN
from procgen_client.dataset.trajectories import Header, Trajectories
from procgen_client.errors import FailedPreconditionError, InvalidArgumentError
from procgen_client.options import EnvironmentOptions, check_names
from procgen_client.pool import Pool
from procgen_client.tools.art import ART_VARIABLE, Art

# Options of a pool that change the drawn frames and nothing else.
DRAWING_OPTIONS = ("screen_size", "grayscale_obs", "layout")
# Called with the number of environment steps that were played since the last call.
Report = Callable[[int], None]
_BLOCK_LENGTH = 64


class Block(NamedTuple):
    """Successive steps of all environments, in order of time. n steps, N environments."""

    start: int  # Index of the first step.
    # Row n is the first of the next block. Valid until that is played.
    observations: np.ndarray | None  # uint8 [n + 1, N, *F]; None: not drawn.
    final_observations: dict[tuple[int, int], np.ndarray]  # By row and environment: see Pool.step.
    rewards: np.ndarray  # float32 [n, N]
    terminated: np.ndarray  # bool [n, N]
    truncated: np.ndarray  # bool [n, N]
    prev_level_complete: np.ndarray  # bool [n, N]
    level_seeds: np.ndarray  # int32 [n + 1, N]

    @property
    def step_count(self) -> int:
        """Number of steps, n."""
        return len(self.rewards)


class Writer(Protocol):
    """Receives the frames of a replay."""

    block_length: int  # Number of steps in a block; the last may have fewer.
    needs_final_observations: bool

    def write(self, block: Block) -> None:
        """Takes the next block, whose observations are drawn."""


def play(
    header: Header,
    actions: npt.ArrayLike,
    *,
    art: Art | None = None,
    drawing: Mapping[str, Any] | None = None,
    writer: Writer | None = None,
    report: Report = lambda _: None,
    num_threads: int | None = None,
) -> Trajectories:
    """Plays actions from the start of the environments.

    Args:
        header: The environments; its art and engine are replaced by those that are used.
        actions: int [N, T], each in [-1, 15).
        art: As for Pool.
        drawing: Values of DRAWING_OPTIONS. If there are any, no digests are made.
        writer: Receives the frames. None: only frames with a digest are drawn.
        report: Called with each block.
        num_threads: As for Pool.

    Raises:
        InvalidArgumentError: An action or option is out of range or of a wrong shape.
        ProcgenError: As Pool.
    """
    given = checked_actions(actions, header.env_count, header.step_count)
    art_name = art_or_default(art)
    header = dataclasses.replace(header, art=art_name, engine=_library.library().version)
    digests: list[int] = []
    blocks = []
    with open_pool(header, art=art_name, drawing=drawing, num_threads=num_threads) as pool:
        for block in _rollout(pool, given, header.digest_interval, digests, writer):
            if writer is not None:
                writer.write(block)
            report(block.step_count * header.env_count)
            blocks.append(block._replace(observations=None, final_observations={}))

    def joined(name: str) -> np.ndarray:
        rows = [getattr(block, name)[: block.step_count] for block in blocks]
        return np.ascontiguousarray(np.concatenate(rows).T)

    last_levels = blocks[-1].level_seeds[-1:].T
    return Trajectories(
        header,
        given,
        *(joined("rewards"), joined("terminated"), joined("truncated")),
        joined("prev_level_complete"),
        np.concatenate([joined("level_seeds"), last_levels], axis=1),
        np.array([] if drawing else digests, np.uint32),
    )


def replay(
    trajectories: Trajectories,
    name: str,
    *,
    art: Art | None = None,
    drawing: Mapping[str, Any] | None = None,
    writer: Writer | None = None,
    report: Report = lambda _: None,
    num_threads: int | None = None,
) -> None:
    """Plays trajectories again and compares all that they have.

    Args:
        trajectories: From a file.
        name: The file's name, for errors.
        art: None: the recorded one.
        drawing, writer, report, num_threads: As :func:`play`.

    Raises:
        DataLossError: Something differs.
        FailedPreconditionError: The recorded art is the project's own, and a variable names
            another.
        ProcgenError: As Pool.
    """
    if art is None:
        art = recorded_art(trajectories.header)
    replayed = play(
        *(trajectories.header, trajectories.actions),
        art=art, drawing=drawing, writer=writer, report=report, num_threads=num_threads,
    )  # fmt: skip
    trajectories.require_equal(replayed, name)


def open_pool(
    header: Header,
    *,
    art: Art | None,
    drawing: Mapping[str, Any] | None = None,
    num_threads: int | None = None,
) -> Pool:
    """Makes the environments of a header.

    Raises:
        FailedPreconditionError: A variable names a server.
        ProcgenError: As Pool.
    """
    check_names("drawing", drawing or {}, DRAWING_OPTIONS)
    check_names("trajectories", header.options, EnvironmentOptions.__annotations__)
    if os.environ.get(SERVER_VARIABLE):
        raise FailedPreconditionError(
            f"{SERVER_VARIABLE} is {os.environ[SERVER_VARIABLE]}, but data sets are played in this "
            "process: unset it"
        )
    return Pool(
        header.game,
        header.env_count,
        art=art,
        first_env=header.first_env,
        total_env_count=header.total_env_count,
        num_threads=num_threads,
        **header.options,
        **(drawing or {}),
    )


def art_or_default(art: Art | None) -> str | None:
    """Returns the art of a pool that is given `art`; None: the project's own."""
    given = os.environ.get(ART_VARIABLE) if art is None else art
    return None if given is None else os.fspath(given)


def recorded_art(header: Header) -> str | None:
    """Returns the art with which trajectories were recorded.

    Raises:
        FailedPreconditionError: It is the project's own, and a variable names another.
    """
    if header.art is None and os.environ.get(ART_VARIABLE):
        raise FailedPreconditionError(
            f"the recorded art is the project's own, but {ART_VARIABLE} is "
            f"{os.environ[ART_VARIABLE]}: unset it, or choose an art"
        )
    return header.art


def checked_actions(actions: npt.ArrayLike, env_count: int, step_count: int) -> np.ndarray:
    """Returns actions as int8 [env_count, step_count].

    Raises:
        InvalidArgumentError: They have another shape or type, or one is out of range.
    """
    given = np.asarray(actions)
    if given.shape != (env_count, step_count) or given.dtype.kind not in "iu" or not given.size:
        raise InvalidArgumentError(
            f"actions has shape {list(given.shape)} and type {given.dtype}; it has one integer for "
            f"each of {env_count} environments and {step_count} steps, at least one of each"
        )
    wrong = given[(given < ACTION_MIN) | (given >= ACTION_COUNT)]
    if len(wrong):
        raise InvalidArgumentError(
            f"actions contains {wrong[0]}; actions are {ACTION_MIN} ... {ACTION_COUNT - 1}"
        )
    return given.astype(np.int8)


def _rollout(
    pool: Pool,
    actions: np.ndarray,
    digest_interval: int,
    digests: list[int],
    writer: Writer | None,
) -> Iterator[Block]:
    """Yields blocks of all steps; appends digests of frames."""
    by_step = np.ascontiguousarray(actions.T)
    step_count, env_count = by_step.shape
    length = min(_BLOCK_LENGTH if writer is None else writer.block_length, step_count)
    final = writer is not None and writer.needs_final_observations
    rows = length + 1 if writer is not None else 1
    memory = np.empty((rows, env_count, *pool.observation_shape), np.uint8)
    batch = pool.observe(out=memory[0])
    digests.append(zlib.crc32(memory[0]))
    levels = batch.level_seeds.copy()
    for start in range(0, step_count, length):
        count = min(length, step_count - start)
        finals: dict[tuple[int, int], np.ndarray] = {}
        block = Block(
            start,
            None if writer is None else memory[: count + 1],
            finals,
            rewards=np.empty((count, env_count), np.float32),
            terminated=np.empty((count, env_count), np.bool_),
            truncated=np.empty((count, env_count), np.bool_),
            prev_level_complete=np.empty((count, env_count), np.bool_),
            level_seeds=np.empty((count + 1, env_count), np.int32),
        )
        block.level_seeds[0] = levels
        for row in range(count):
            has_digest = (start + row + 1) % digest_interval == 0
            frame = memory[row + 1 if writer is not None else 0]
            draws = writer is not None or has_digest
            batch = pool.step(
                by_step[start + row], observe=draws, out=frame if draws else None,
                final_observations=final,
            )  # fmt: skip
            for name in ("rewards", "terminated", "truncated", "prev_level_complete"):
                getattr(block, name)[row] = getattr(batch, name)
            block.level_seeds[row + 1] = batch.level_seeds
            if has_digest:
                digests.append(zlib.crc32(frame))
            if batch.final_observations is not None:
                for env in np.flatnonzero(batch.ended):
                    finals[row, int(env)] = batch.final_observations[env].copy()
        levels = block.level_seeds[-1]
        yield block
        if writer is not None:
            memory[0] = memory[count]
