"""Client of Procgen Server: batches of the sixteen Procgen games over gRPC.

A Gymnasium vector environment on a local server, which starts and stops with the program
(``server="host:50051"`` uses a running one)::

    import numpy as np
    from procgen_client import ProcgenVectorEnv

    with ProcgenVectorEnv("coinrun", num_envs=64, distribution_mode="easy", num_levels=200) as env:
        observations, infos = env.reset(seed=0)  # uint8 [64, 64, 64, 3]
        for _ in range(100):
            actions = np.random.randint(0, 15, env.num_envs)
            observations, rewards, terminations, truncations, infos = env.step(actions)

Environments:

- :class:`ProcgenVectorEnv`, :class:`ProcgenGymEnv`: Gymnasium's VectorEnv and Env. Options are
  those of :meth:`Client.create_pool`; ``env.step(actions, out=x)`` writes observations into an
  array or tensor; ``env.save(path)`` and ``env.load(path)`` are checkpoints.
- :class:`ProcgenEnv`, :class:`ProcgenGym3Env`: the APIs of Procgen 0.10.7;
  :class:`ToBaselinesVecEnv` makes the first of the second. :mod:`procgen_client.env` has the names
  of upstream's module `procgen.env`.

Pools, the server's own API::

    with connect("localhost:50051") as client, client.create_pool("bigfish", 64) as pool:
        batch = pool.step(np.zeros(64, int))
        print(batch.rewards, batch.ended, batch.level_seeds)

- :class:`Client`, :class:`Pool`, :class:`Batch`: requests sent ahead, slices, states, watching.
- :class:`DoubleBufferedSampler`: rollouts in which neither server nor policy waits.
- :class:`LevelSampler`, :class:`Reset`: weighted levels; episodes that start at once.
- :mod:`procgen_client.aio`: the same for asyncio.

Beside them:

- :class:`EpisodeStatistics`, :class:`NormalizeReward`, :class:`VideoRecorder`: returns and lengths
  of episodes; rewards divided by the deviation of returns; mp4 files.
- :class:`ServerProcess`, :class:`Credentials`: a server as a child process; TLS and tokens.
- ``procgen-evaluate`` (:mod:`procgen_client.tools.evaluate`): scores of a policy.

Every error is a :class:`ProcgenError`, whose message has the value given and the values allowed;
:mod:`procgen_client.errors` has a class per status code. An object belongs to one thread at a time;
a Client may be shared. Variables: ``PROCGEN_SERVER`` (address), ``PROCGEN_SERVER_BINARY``
(program of local servers), ``PROCGEN_SERVER_CA`` and ``PROCGEN_SERVER_TOKEN`` (see Credentials).
"""

import sys
from pathlib import Path

try:
    import google.protobuf  # noqa: F401
except ImportError:  # The wheel with native parts has a copy.
    sys.path.append(str(Path(__file__).resolve().parent / "_vendor"))

try:
    from procgen_client import _proto  # noqa: F401 - checks that the modules were generated
except ImportError:
    raise ImportError(
        "procgen_client._proto is missing: build the checkout, or run clients/python/generate.sh"
    ) from None

from procgen_client._requests import ACTION_COUNT, ACTION_MIN, Reset
from procgen_client.batch import Batch
from procgen_client.client import Client, connect
from procgen_client.credentials import Credentials
from procgen_client.envs import _gym, _gymnasium
from procgen_client.envs._gymnasium import AutoresetMode
from procgen_client.envs.baselines_env import ProcgenEnv, ToBaselinesVecEnv
from procgen_client.envs.gym_env import ProcgenGymEnv
from procgen_client.envs.procgen_compat import ENV_NAMES, ProcgenGym3Env
from procgen_client.envs.vector_env import ProcgenVectorEnv
from procgen_client.errors import ProcgenError
from procgen_client.options import LevelSampler
from procgen_client.pool import Pool
from procgen_client.sampler import DoubleBufferedSampler
from procgen_client.tools.episode_statistics import Episode, EpisodeStatistics
from procgen_client.tools.normalize_reward import NormalizeReward
from procgen_client.tools.server_process import ServerProcess
from procgen_client.tools.video import VideoRecorder

__version__ = "0.1.0"

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
    "Pool",
    "ProcgenEnv",
    "ProcgenError",
    "ProcgenGym3Env",
    "ProcgenGymEnv",
    "ProcgenVectorEnv",
    "Reset",
    "ServerProcess",
    "ToBaselinesVecEnv",
    "VideoRecorder",
    "connect",
]

_gymnasium.register_environments()
_gym.register_environments()
