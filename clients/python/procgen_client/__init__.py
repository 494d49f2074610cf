"""Client of Procgen Server: batches of the sixteen Procgen games over gRPC.

- :class:`ProcgenVectorEnv`: a pool of environments with Gymnasium's vector interface;
  :class:`ProcgenGymEnv`: one of them, with Gymnasium's other interface.
- :class:`ProcgenGym3Env`, :class:`ProcgenEnv`: the interfaces of Procgen 0.10.7.
- :class:`Client` and :class:`Pool`: the server's own interface, with requests sent ahead, slices
  and next levels.
- :mod:`procgen_client.aio`: the same for asyncio.
- :class:`EpisodeStatistics`, :class:`VideoRecorder`: what was played, in numbers and in pictures.
- :class:`ServerProcess`: a server of one's own, started and stopped.
- :mod:`procgen_client.errors`: what can go wrong.
"""

import importlib.util
import sys
from pathlib import Path

if importlib.util.find_spec("google") is None or importlib.util.find_spec("google.protobuf") is None:
    sys.path.append(str(Path(__file__).resolve().parent / "_vendor"))  # In the wheel with everything.

try:
    from procgen_client import _proto  # noqa: F401 - only to see whether it is there
except ImportError:
    raise ImportError(
        "procgen_client is used from a checkout whose protos were not generated yet: build it, or "
        "run clients/python/generate.sh"
    ) from None

from procgen_client._requests import ACTION_COUNT, ACTION_MIN, Reset
from procgen_client.batch import Batch
from procgen_client.client import Client, connect
from procgen_client.credentials import Credentials
from procgen_client.envs import _gym, _gymnasium
from procgen_client.envs._gymnasium import AutoresetMode
from procgen_client.envs.gym_env import ProcgenGymEnv
from procgen_client.envs.procgen_compat import ENV_NAMES, ProcgenEnv, ProcgenGym3Env
from procgen_client.envs.vector_env import ProcgenVectorEnv
from procgen_client.errors import ProcgenError
from procgen_client.options import LevelSampler
from procgen_client.pool import Pool
from procgen_client.tools.episode_statistics import Episode, EpisodeStatistics
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
    "Episode",
    "EpisodeStatistics",
    "LevelSampler",
    "Pool",
    "ProcgenEnv",
    "ProcgenError",
    "ProcgenGym3Env",
    "ProcgenGymEnv",
    "ProcgenVectorEnv",
    "Reset",
    "ServerProcess",
    "VideoRecorder",
    "connect",
]

_gymnasium.register_environments()
_gym.register_environments()
