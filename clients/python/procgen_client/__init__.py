"""Client of Procgen Server: batches of the sixteen Procgen games over gRPC.

- :class:`ProcgenVectorEnv`, :class:`ProcgenGymEnv`: Gymnasium's VectorEnv and Env.
- :class:`ProcgenEnv`, :class:`ProcgenGym3Env`: the APIs of Procgen 0.10.7.
- :class:`Client`, :class:`Pool`: the server's API, with requests sent ahead, slices and states.
- :mod:`procgen_client.aio`: the same for asyncio.
- :class:`EpisodeStatistics`, :class:`VideoRecorder`: returns and lengths of episodes; mp4 files.
- :class:`ServerProcess`: a server as a child process.
- :mod:`procgen_client.errors`: the exceptions.
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
