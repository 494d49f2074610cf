"""The sixteen Procgen games in batches: in this process, or on servers.

A Gymnasium vector environment, stepped in this process (``server="host:50051"`` steps it on a
server, with equal results)::

    import numpy as np
    from procgen_client import ProcgenVectorEnv

    with ProcgenVectorEnv("coinrun", num_envs=64, distribution_mode="easy", num_levels=200) as env:
        observations, infos = env.reset(seed=0)  # uint8 [64, 64, 64, 3]
        for _ in range(100):
            actions = np.random.randint(0, 15, env.num_envs)
            observations, rewards, terminations, truncations, infos = env.step(actions)

Environments:

- :class:`ProcgenVectorEnv`, :class:`ProcgenGymEnv`: Gymnasium's VectorEnv and Env. Options are
  those of :class:`Pool`; ``env.step(actions, out=x)`` writes observations into an array or tensor;
  ``env.save(path)`` and ``env.load(path)`` are checkpoints.
- :class:`ProcgenEnv`, :class:`ProcgenGym3Env`: the APIs of Procgen 0.10.7;
  :class:`ToBaselinesVecEnv` makes the first of the second. :mod:`procgen_client.env` has the names
  of upstream's module `procgen.env`.

Pools, which these are made of::

    with Pool("bigfish", 64) as pool:
        batch = pool.step(np.zeros(64, int))
        print(batch.rewards, batch.ended, batch.level_seeds)

- :class:`Pool`, :class:`Batch`: requests sent ahead, slices, states.
- :class:`DoubleBufferedSampler`: rollouts in which neither environments nor policy wait.
- :class:`LevelSampler`, :class:`Reset`: weighted levels; episodes that start at once.
- :func:`catalog`: the games, their modes, actions, kinds of objects and variants.
- :func:`decode_state`, :func:`encode_state`: a snapshot as a :class:`State`, a dict, and back;
  :func:`goal_positions`, :func:`move_goal`, :func:`remove_goals` edit it. :class:`Objects`:
  positions and velocities of a batch, from ``pool.objects()``.
- :mod:`procgen_client.aio`: pools for asyncio.

Servers:

- :class:`Client`: a connection, which also lists and watches pools; :class:`Credentials`: TLS and
  tokens; :class:`ServerProcess`: a server as a child process.

Beside them:

- :class:`EpisodeStatistics`, :class:`NormalizeReward`, :class:`VideoRecorder`: returns and lengths
  of episodes; rewards divided by the deviation of returns; mp4 files.
- ``procgen-evaluate`` (:mod:`procgen_client.tools.evaluate`): scores of a policy.
- ``procgen-dataset`` (:mod:`procgen_client.dataset`): data sets of frames, as seeds and actions.

Every error is a :class:`ProcgenError`, whose message has the value given and the values allowed;
:mod:`procgen_client.errors` has a class per status code. An object belongs to one thread at a time;
a Client may be shared. Variables: ``PROCGEN_SERVER`` (address of the server of all pools),
``PROCGEN_ART`` (art of pools in this process), ``PROCGEN_SERVER_CA`` and ``PROCGEN_SERVER_TOKEN``
(see Credentials), ``PROCGEN_SERVER_BINARY`` (program of ServerProcess).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from procgen_client._requests import ACTION_COUNT, ACTION_MIN, Reset
from procgen_client.batch import Batch
from procgen_client.catalog import catalog
from procgen_client.credentials import Credentials
from procgen_client.envs import _gym, _gymnasium
from procgen_client.envs._gymnasium import AutoresetMode
from procgen_client.envs.baselines_env import ProcgenEnv, ToBaselinesVecEnv
from procgen_client.envs.gym_env import ProcgenGymEnv
from procgen_client.envs.procgen_compat import ENV_NAMES, ProcgenGym3Env
from procgen_client.envs.vector_env import ProcgenVectorEnv
from procgen_client.errors import ProcgenError
from procgen_client.objects import Objects
from procgen_client.options import LevelSampler
from procgen_client.pool import Pool
from procgen_client.sampler import DoubleBufferedSampler
from procgen_client.states import (
    State,
    decode_state,
    encode_state,
    goal_positions,
    move_goal,
    remove_goals,
)
from procgen_client.tools.episode_statistics import Episode, EpisodeStatistics
from procgen_client.tools.normalize_reward import NormalizeReward
from procgen_client.tools.server_process import ServerProcess
from procgen_client.tools.video import VideoRecorder

if TYPE_CHECKING:
    from procgen_client.client import Client, connect

__version__ = "0.9.0"

__all__ = [
    "ACTION_COUNT",
    "ACTION_MIN",
    "ENV_NAMES",
    "AutoresetMode",
    "Batch",
    "Client",
    "Credentials",
    "DoubleBufferedSampler",
    "Episode",
    "EpisodeStatistics",
    "LevelSampler",
    "NormalizeReward",
    "Objects",
    "Pool",
    "ProcgenEnv",
    "ProcgenError",
    "ProcgenGym3Env",
    "ProcgenGymEnv",
    "ProcgenVectorEnv",
    "Reset",
    "ServerProcess",
    "State",
    "ToBaselinesVecEnv",
    "VideoRecorder",
    "catalog",
    "connect",
    "decode_state",
    "encode_state",
    "goal_positions",
    "move_goal",
    "remove_goals",
]


def __getattr__(name: str) -> Any:  # noqa: ANN401
    """Loads what needs Protocol Buffers when it is used."""
    if name not in ("Client", "connect"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from procgen_client import client

    return getattr(client, name)


_gymnasium.register_environments()
_gym.register_environments()
