"""Programs for upstream and Gym, Gymnasium's predecessor, run with this client.

Debian has no Gym, so a stub package replaces it in a second Python process, as in
gymnasium_test.py. The program is in the manner of CleanRL's ppo_procgen.py, which is written for
Gym 0.23; its wrappers are gym/wrappers/ in brief.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from procgen_client import ServerProcess

_GYM = {
    "__init__.py": """
import importlib
from gym import envs, spaces
from gym.envs import registration

class Env:
    metadata = {}
    spec = None

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
    # transform_observation.py, record_episode_statistics.py, record_video.py with
    # monitoring/video_recorder.py, of Gym 0.21 to 0.23.
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

class RecordVideo(gym.Wrapper):
    def __init__(self, env, folder):
        super().__init__(env)
        assert "rgb_array" in env.metadata.get("render.modes", [])
        self.frames_per_second = env.metadata["video.frames_per_second"]
        self.frames = []

    def step(self, action):
        frame = self.env.render(mode="rgb_array")
        assert frame.shape[0] < 4096 and frame.shape[1] < 4096, "no encoder takes more"
        self.frames.append(frame)
        return self.env.step(action)
""",
}

_CLEANRL = """
import sys
import warnings
import gym
import gym.wrappers
import numpy as np
from procgen_client import ProcgenEnv

for num_envs in (64, 2):
    envs = ProcgenEnv(
        num_envs=num_envs, env_name="bigfish", num_levels=0, start_level=0,
        distribution_mode="easy", server=sys.argv[1],
    )
    envs = gym.wrappers.TransformObservation(envs, lambda obs: obs["rgb"])
    envs.single_action_space = envs.action_space
    envs.single_observation_space = envs.observation_space["rgb"]
    envs.is_vector_env = True
    envs = gym.wrappers.RecordEpisodeStatistics(envs)
    envs = gym.wrappers.RecordVideo(envs, "videos")
    assert isinstance(envs.single_action_space, gym.spaces.Discrete)
    assert isinstance(envs.single_observation_space, gym.spaces.Box)
    assert isinstance(envs.observation_space, gym.spaces.Dict)
    observations = envs.reset()
    assert observations.shape == (num_envs, 64, 64, 3)
    ended = []
    for step in range(300):
        actions = np.random.randint(0, envs.single_action_space.n, num_envs).astype(np.float32)
        observations, rewards, dones, infos = envs.step(actions)
        ended += [info["episode"]["r"] for info in infos if "episode" in info]
    assert ended or num_envs == 2
    assert envs.frames_per_second == 15
    assert {frame.shape for frame in envs.frames} == {(64, 64, 3)}
    envs.close()

# Upstream, gym_registration.py: one environment, with the observation alone; the observation of the
# step that ends an episode is the one before it, and resets within an episode are ignored.
env = gym.make(
    "procgen_client:procgen-maze-v0", distribution_mode="easy", rand_seed=1, server=sys.argv[1]
)
assert isinstance(env, gym.Env)
assert isinstance(env.action_space, gym.spaces.Discrete)
first = env.reset()
assert first.shape == env.observation_space.shape == (64, 64, 3)
observation, reward, done, info = env.step(4)
assert (type(reward), done) == (float, False)
last, _, done, info = env.step(-1)
assert done
np.testing.assert_array_equal(last, observation)
after = env.reset()
assert (after != last).any()
np.testing.assert_array_equal(after, env.render("rgb_array"))
for call in (lambda: env.seed(3), lambda: (env.step(4), env.reset())):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        call()
    assert len(caught) == 1
env.close()
env.close()
try:
    gym.make("procgen-maze-v0", render_mode="human")
except ValueError as error:
    assert "no window" in str(error)
else:
    raise AssertionError("render_mode='human' is not rejected")
"""


def test_cleanrl_style_program_runs_with_gym(
    server: ServerProcess, tmp_path: Path
) -> None:
    for name, text in _GYM.items():
        file = tmp_path / "gym" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    result = subprocess.run(
        [sys.executable, "-c", _CLEANRL, server.address],
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])},
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
