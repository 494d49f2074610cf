"""Policies of recordings: what chooses the actions."""

from __future__ import annotations

import numpy as np

from procgen_client._requests import ACTION_COUNT
from procgen_client.dataset.play import Report, open_pool
from procgen_client.dataset.trajectories import Header
from procgen_client.errors import InvalidArgumentError
from procgen_client.tools.evaluate import load_policy
from procgen_client.tools.play_episodes import Policy, has_parameter

STICKINESS = 0.9


def check_policy(name: str) -> None:
    """Raises InvalidArgumentError unless there is such a policy."""
    if needs_frames(name):
        load_policy(name)


def needs_frames(name: str) -> bool:
    """Returns whether a policy plays, in contrast to one that only draws random numbers."""
    return name != "random" and _stickiness(name) is None


def policy_actions(header: Header, seed: int, report: Report) -> np.ndarray:
    """Returns the actions of the header's policy, int8 [N, T].

    Args:
        header: The environments, with the policy: "random"; "sticky" or "sticky:P", which repeats
            an action with probability P; or "MODULE:FUNCTION", a function from the game's name to
            a policy as of procgen-evaluate. If it has a parameter `seed`, that is a different
            number for each part of a recording.
        seed: Seeds the policy, together with the game and the first environment.
        report: Called with numbers of environment steps that a policy has played, if it needs
            frames.

    Raises:
        InvalidArgumentError: There is no such policy, or its actions are wrong.
        ProcgenError: As Pool.
    """
    seeds = np.random.SeedSequence([seed % 2**32, header.first_env, *header.game.encode()])
    shape = (header.env_count, header.step_count)
    if not needs_frames(header.policy):
        stickiness = _stickiness(header.policy)
        random = np.random.default_rng(seeds)
        actions = random.integers(0, ACTION_COUNT, shape, np.int8)
        return actions if stickiness is None else _repeated(actions, stickiness, random)
    make_policy = load_policy(header.policy)
    keywords: dict[str, int] = {}
    if has_parameter(make_policy, "seed"):
        keywords["seed"] = int(seeds.generate_state(1)[0])
    return _played(header, make_policy(header.game, **keywords), report)


def _repeated(actions: np.ndarray, stickiness: float, random: np.random.Generator) -> np.ndarray:
    """Replaces each action by its predecessor with a probability."""
    columns = np.arange(actions.shape[1])
    chosen = np.where(random.random(actions.shape) < stickiness, 0, columns)
    return np.take_along_axis(actions, np.maximum.accumulate(chosen, axis=1), axis=1)


def _played(header: Header, policy: Policy, report: Report) -> np.ndarray:
    """Returns the actions of a policy that needs frames."""
    is_recurrent = has_parameter(policy, "first")
    taken = np.empty((header.step_count, header.env_count), np.int8)
    with open_pool(header, art=header.art, num_threads=0) as pool:
        batch = pool.observe()
        for t in range(header.step_count):
            memory = {"first": batch.first} if is_recurrent else {}
            actions = np.asarray(policy(batch.observations, **memory))
            batch = pool.step(actions)
            taken[t] = actions
            report(header.env_count)
    return np.ascontiguousarray(taken.T)


def _stickiness(name: str) -> float | None:
    """Returns the probability of a sticky policy; None: it is another."""
    kind, separator, number = name.partition(":")
    if kind != "sticky":
        return None
    try:
        probability = float(number) if separator else STICKINESS
    except ValueError:
        probability = -1.0
    if not 0 <= probability < 1:
        raise InvalidArgumentError(f"policy is {name!r}; the P of sticky:P is in [0, 1)")
    return probability
