"""The names of upstream's module `procgen.env`, for programs that import them from there."""

from procgen_client.envs.baselines_env import ProcgenEnv, ToBaselinesVecEnv
from procgen_client.envs.procgen_compat import ENV_NAMES, ProcgenGym3Env

__all__ = ["ENV_NAMES", "ProcgenEnv", "ProcgenGym3Env", "ToBaselinesVecEnv"]
