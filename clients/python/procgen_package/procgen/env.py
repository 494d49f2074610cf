"""The names of upstream's module `procgen.env`."""

from procgen_client.env import ENV_NAMES, ProcgenEnv, ProcgenGym3Env, ToBaselinesVecEnv

__all__ = ["ENV_NAMES", "ProcgenEnv", "ProcgenGym3Env", "ToBaselinesVecEnv"]
