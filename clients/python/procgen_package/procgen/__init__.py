"""The package `procgen` of Procgen 0.10.7 ("upstream"), over procgen_client.

For programs and libraries that import `procgen` themselves. As upstream, it imports Gym where that
is installed: spaces are Gym's then, and ``gym.make("procgen:procgen-coinrun-v0")`` has all games.
"""

from __future__ import annotations

import contextlib
from importlib import metadata

try:
    _upstream = metadata.version("procgen")
except metadata.PackageNotFoundError:
    pass
else:
    raise ImportError(
        f"the distribution procgen {_upstream} is installed, which has a package procgen as well: "
        "uninstall it, or procgen-server-procgen"
    )
with contextlib.suppress(ModuleNotFoundError):
    import gym as _gym  # noqa: F401 - before procgen_client, which then has its spaces and ids

from procgen_client import __version__
from procgen_client.env import ENV_NAMES, ProcgenEnv, ProcgenGym3Env, ToBaselinesVecEnv
from procgen_client.envs._gym import register_environments

# Again, if the program imported procgen_client before Gym.
register_environments()

__all__ = ["ENV_NAMES", "ProcgenEnv", "ProcgenGym3Env", "ToBaselinesVecEnv", "__version__"]
