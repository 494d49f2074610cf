"""A package `gym` in brief, since Debian has none: what programs for Gym 0.21 to 0.23 use of it."""

from __future__ import annotations

import os
import sys
from pathlib import Path

_GYM = {
    "__init__.py": """
import importlib
from gym import envs, spaces
from gym.envs import registration

__version__ = "0.21.0"

class Env:
    metadata = {}
    spec = None

    @property
    def unwrapped(self):
        return self

class Wrapper(Env):
    def __init__(self, env):
        self.env = env
        self.action_space, self.observation_space = env.action_space, env.observation_space
        self.metadata, self.reward_range, self.spec = env.metadata, env.reward_range, env.spec

    def __getattr__(self, name):
        return getattr(self.env, name)

    def reset(self, **kwargs):
        return self.env.reset(**kwargs)

    def step(self, action):
        return self.env.step(action)

    def render(self, mode="human", **kwargs):
        return self.env.render(mode, **kwargs)

def make(id, **kwargs):
    module, _, name = id.rpartition(":")
    if module:
        importlib.import_module(module)
    entry_point, defaults = registration.registry[name]
    module, attribute = entry_point.split(":")
    return getattr(importlib.import_module(module), attribute)(**(defaults | kwargs))
""",
    "envs/__init__.py": "from gym.envs import registration",
    "envs/registration.py": """
registry = {}

def register(id, entry_point=None, kwargs=None):
    assert id not in registry, "Cannot re-register id"
    registry[id] = (entry_point, kwargs or {})
""",
    "spaces.py": """
class Space:
    pass

class Box(Space):
    def __init__(self, low, high, shape, dtype):
        self.low, self.high, self.shape, self.dtype = low, high, shape, dtype

class Discrete(Space):
    def __init__(self, n):
        self.n = n

class Dict(Space):
    def __init__(self, spaces):
        self.spaces = spaces

    def __getitem__(self, name):
        return self.spaces[name]
""",
    # transform_observation.py, record_episode_statistics.py of Gym 0.21 to 0.23.
    "wrappers.py": """
import numpy as np
import gym

class TransformObservation(gym.Wrapper):
    def __init__(self, env, f):
        super().__init__(env)
        self.f = f

    def reset(self):
        return self.f(self.env.reset())

    def step(self, action):
        observation, *others = self.env.step(action)
        return (self.f(observation), *others)

class RecordEpisodeStatistics(gym.Wrapper):
    def __init__(self, env):
        super().__init__(env)
        self.num_envs = getattr(env, "num_envs", 1)
        self.returns = np.zeros(self.num_envs)

    def step(self, action):
        observation, rewards, dones, infos = self.env.step(action)
        self.returns += rewards
        for i in range(len(dones)):
            if dones[i]:
                infos[i] = infos[i] | {"episode": {"r": self.returns[i]}}
                self.returns[i] = 0
        return observation, rewards, dones, infos
""",
}


def write_gym(folder: Path) -> dict[str, str]:
    """Writes the package into a folder; returns the variables of a process that imports it."""
    for name, text in _GYM.items():
        file = folder / "gym" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    return os.environ | {"PYTHONPATH": os.pathsep.join([str(folder), *sys.path])}
