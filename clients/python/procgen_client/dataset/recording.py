"""Recordings: a policy plays games, and its trajectories are files."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from procgen_client._requests import ENV_COUNT_MAX, in_range
from procgen_client.dataset.play import Report, art_or_default, open_pool, play
from procgen_client.dataset.policies import check_policy, needs_frames, policy_actions
from procgen_client.dataset.trajectories import SUFFIX, Header, Trajectories, load, part_name
from procgen_client.errors import InvalidArgumentError
from procgen_client.options import game_names
from procgen_client.tools.art import Art

# Environments of a part, which one core plays; and about how many steps an environment takes.
PART_ENV_COUNT = 64
_STEP_COUNT = 4096
# An environment takes a multiple of these steps.
_STEP_UNIT = 64


class Part(NamedTuple):
    """A trajectory file to be written."""

    path: Path
    header: Header  # Without the engine.
    seed: int  # Of the policy.

    @property
    def is_done(self) -> bool:
        """Whether the file exists."""
        return self.path.exists()

    @property
    def step_count(self) -> int:
        """Number of environment steps."""
        return self.header.env_count * self.header.step_count


def parts_of(
    folder: str | Path,
    games: str | Sequence[str],
    *,
    step_count: int,
    env_count: int | None = None,
    policy: str = "random",
    seed: int = 0,
    art: Art | None = None,
    digest_interval: int = 64,
    options: Mapping[str, Any] | None = None,
) -> list[Part]:
    """Returns the parts of a recording, also those that are done.

    Args:
        folder: Receives the files.
        games: A game, or several.
        step_count: Environment steps of each game. They are rounded up, so that each environment
            takes equally many, a multiple of 64.
        env_count: Environments of each game. None: so many that each takes about 4,096 steps.
        policy: As for policies.policy_actions.
        seed: Seeds policy and levels.
        art: As for Pool.
        digest_interval: Steps from one digest of frames to the next; 1: every frame has one.
        options: Of options.EnvironmentOptions, without rand_seed.

    Raises:
        InvalidArgumentError: An argument is out of range, or the folder has files of another
            recording.
        ProcgenError: As Pool.
    """
    in_range("steps", step_count, 1, 2**63 - 1)
    in_range("environments", 1 if env_count is None else env_count, 1, ENV_COUNT_MAX)
    check_policy(policy)
    if env_count is None:
        env_count = min(
            PART_ENV_COUNT * _quotient(step_count, PART_ENV_COUNT * _STEP_COUNT),
            _quotient(step_count, _STEP_UNIT),
        )
    length = _quotient(step_count, env_count * _STEP_UNIT) * _STEP_UNIT
    part_count = _quotient(env_count, PART_ENV_COUNT)
    parts = []
    for game in game_names(games):
        for part in range(part_count):
            first = part * PART_ENV_COUNT
            header = Header(
                game=game,
                env_count=min(PART_ENV_COUNT, env_count - first),
                step_count=length,
                options={**(options or {}), "rand_seed": seed},
                first_env=first,
                total_env_count=env_count,
                art=art_or_default(art),
                policy=policy,
                digest_interval=digest_interval,
            )
            name = part_name(game, part, part_count)
            parts.append(Part(Path(folder) / f"{name}{SUFFIX}", header, seed))
        # Reports wrong options before any work.
        open_pool(dataclasses.replace(header, env_count=1), art=art, num_threads=0).close()
        _require_no_other_parts(Path(folder), game, part_count)
    for each in parts:
        if each.is_done:
            _require_same(each)
    return parts


def record(part: Part, report: Report = lambda _: None) -> None:
    """Writes a part, unless it is done. The file appears when it is complete.

    Args:
        part: From parts_of.
        report: Called with numbers of environment steps that are recorded.

    Raises:
        OSError: The file cannot be written.
        ProcgenError: As policies.policy_actions.
    """
    if part.is_done:
        return
    Path(part.path).parent.mkdir(parents=True, exist_ok=True)
    actions = policy_actions(part.header, part.seed, report)
    # What a policy has played is played again, for its digests, and counted once.
    trajectories = play(
        *(part.header, actions), art=part.header.art, num_threads=0,
        report=(lambda _: report(0)) if needs_frames(part.header.policy) else report,
    )  # fmt: skip
    trajectories.save(part.path)


def from_actions(
    game: str,
    actions: npt.ArrayLike,
    *,
    art: Art | None = None,
    rewards: npt.ArrayLike | None = None,
    policy: str = "",
    digest_interval: int = 64,
    **options: Any,
) -> Trajectories:
    """Returns the trajectories of actions that were taken elsewhere, such as with Procgen 0.10.7.

    Args:
        game: Name of the game.
        actions: int [N, T]: actions of N environments that were made with these options.
        art: As for Pool.
        rewards: float [N, T]: rewards that were received, which have to be equal. None: unknown.
        policy: What chose the actions; for people.
        digest_interval: Steps from one digest of frames to the next.
        **options: Of options.EnvironmentOptions; a rand_seed is required.

    Raises:
        InvalidArgumentError: An argument is out of range, rand_seed is missing, or the rewards
            differ, so that these are not the options.
        ProcgenError: As Pool.
    """
    if options.get("rand_seed") is None:
        raise InvalidArgumentError(
            "rand_seed is missing; without the seed that the environments had, no frame is known"
        )
    shape = np.shape(actions)
    if len(shape) != 2:
        raise InvalidArgumentError(
            f"actions has shape {list(shape)}; it is [environments, steps]"
        )
    header = Header(
        game, shape[0], shape[1], options, policy=policy, digest_interval=digest_interval
    )
    trajectories = play(header, actions, art=art)
    if rewards is not None:
        given = np.asarray(rewards, np.float32)
        if given.shape != shape:
            raise InvalidArgumentError(
                f"rewards has shape {list(given.shape)}; actions has {list(shape)}"
            )
        wrong = np.argwhere((given != trajectories.rewards).T)
        if len(wrong):
            step, env = wrong[0]
            raise InvalidArgumentError(
                f"the reward of environment {env} at step {step} is {given[env, step]}, but these "
                f"options and actions give {trajectories.rewards[env, step]}"
            )
    return trajectories


def _quotient(number: int, divisor: int) -> int:
    """Returns the quotient, rounded up."""
    return -(-number // divisor)


def _require_same(part: Part) -> None:
    """Raises InvalidArgumentError unless an existing file is what the part asks for."""
    existing = load(part.path).header
    for field in dataclasses.fields(Header):
        given, asked = getattr(existing, field.name), getattr(part.header, field.name)
        if field.name != "engine" and given != asked:
            raise InvalidArgumentError(
                f"{part.path} was recorded with {field.name} {given!r}, not with {asked!r}: repeat "
                "the command that records it, or choose another folder"
            )


def _require_no_other_parts(folder: Path, game: str, part_count: int) -> None:
    expected = {f"{part_name(game, part, part_count)}{SUFFIX}" for part in range(part_count)}
    for path in sorted(folder.glob(f"{game}-*{SUFFIX}")):
        if path.name not in expected:
            raise InvalidArgumentError(
                f"{path} is of another recording than {part_count} parts of {game}: repeat the "
                "command that records it, or choose another folder"
            )
