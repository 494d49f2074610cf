"""Policies of finished runs, for procgen-evaluate.

    PROCGEN_RUN=runs/coinrun procgen-evaluate coinrun --mode easy --policy learners.policy:load

PROCGEN_RUN is a run's folder, or a folder with a run's folder for each game.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from learners import checkpoint_file, cpu, rainbow
from learners.agent import Agent, AgentPolicy
from learners.run_folder import CHECKPOINT
from procgen_client.errors import InvalidArgumentError

RUN_VARIABLE = "PROCGEN_RUN"

# From uint8 [N, 64, 64, 3] to int [N]; that of PPO has a second parameter `first`, bool [N].
Policy = Callable[..., np.ndarray]


def load(game: str, seed: int = 0) -> Policy:
    """Returns the policy of the run that PROCGEN_RUN names.

    Args:
        game: Name of the game.
        seed: Of sampled actions. procgen-dataset gives one for each part of a recording.

    Raises:
        InvalidArgumentError: There is no such run, or it was trained on another game.
    """
    folder = Path(os.environ.get(RUN_VARIABLE, "run"))
    if not (folder / CHECKPOINT).exists():
        folder /= game
    if not (folder / CHECKPOINT).exists():
        raise InvalidArgumentError(
            f"{RUN_VARIABLE} is {os.environ.get(RUN_VARIABLE)!r}; it is a folder with a "
            f"{CHECKPOINT}, or one that has such a folder for each game"
        )
    return load_run(folder, game, seed)


def load_run(folder: Path, game: str | None = None, seed: int = 0) -> Policy:
    """Returns the policy of a run; errors as :func:`load`.

    PPO samples actions, as in training and in the paper; Rainbow takes the best ones. Equal calls
    return equal actions.
    """
    checkpoint = checkpoint_file.load(folder / CHECKPOINT)
    options = checkpoint["options"]
    if game is not None and options["game"] != game:
        raise InvalidArgumentError(f"{folder} was trained on {options['game']}, not on {game}")
    cpu.use_one_thread()
    if _is_rainbow(options):
        return rainbow.load_policy(options, checkpoint["learner"])
    return AgentPolicy(_agent_of(checkpoint), seed)


def load_agent(folder: Path) -> tuple[Agent, dict[str, Any]]:
    """Returns the agent of a run of PPO, and the run's options.

    Raises:
        InvalidArgumentError: The folder has no checkpoint, or one of Rainbow.
    """
    if not (folder / CHECKPOINT).exists():
        raise InvalidArgumentError(f"{folder} has no {CHECKPOINT}; it is the folder of a run")
    checkpoint = checkpoint_file.load(folder / CHECKPOINT)
    if _is_rainbow(checkpoint["options"]):
        raise InvalidArgumentError(f"{folder} is a run of Rainbow; it is a run of PPO")
    return _agent_of(checkpoint), checkpoint["options"]


def _is_rainbow(options: dict[str, Any]) -> bool:
    return "value_max" in options


def _agent_of(checkpoint: dict[str, Any]) -> Agent:
    agent = Agent(checkpoint["options"])
    agent.load_state_dict(checkpoint["learner"]["agent"])
    return agent
