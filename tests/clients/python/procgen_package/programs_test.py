"""Programs in the manner of projects that import `procgen` themselves; they run unchanged.

They run with the installed Gym, else with a package in brief. Each is one project's use of the
interface, in our own words.
"""

from __future__ import annotations

import contextlib
import importlib.util
import os
import re
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest
from stub_gym import write_gym

_PACKAGE = Path(__file__).resolve().parents[4] / "clients/python/procgen_package"

_PROGRAMS = {
    # torchrl/envs/libs/procgen.py: finds the package, lists the games, wraps ProcgenEnv, and
    # converts its spaces by their classes in Gym, which it imports afterwards.
    "torchrl": """
import importlib, importlib.util
assert importlib.util.find_spec("procgen") is not None
import procgen
assert len(getattr(procgen, "ENV_NAMES")) == 16
assert importlib.import_module("procgen.env").ENV_NAMES == procgen.ENV_NAMES
env = procgen.ProcgenEnv(4, "coinrun", render_mode=None)
import gym
assert isinstance(env.observation_space, gym.spaces.Dict)
assert isinstance(env.observation_space["rgb"], gym.spaces.Box)
assert isinstance(env.action_space, gym.spaces.Discrete)
assert env.reset()["rgb"].transpose(0, 3, 1, 2).shape == (4, 3, 64, 64)
observations, rewards, dones, infos = env.step(np.zeros(4, np.int64))
assert rewards.reshape(-1, 1).shape == dones.reshape(-1, 1).shape == (4, 1)
""",
    # embodied/envs/procgen.py and from_gym.py of DreamerV3: sizes other than 64 come from get_info.
    "dreamerv3": """
import procgen
import gym
env = gym.make("procgen:procgen-coinrun-v0", distribution_mode="easy", render_mode="rgb_array")
inner = env
while not hasattr(inner, "get_info"):
    inner = inner.env
assert env.reset().shape == env.observation_space.shape == (64, 64, 3)
done, steps = False, 0
while not done:
    observation, reward, done, info = env.step(env.action_space.n - 1 if steps else 4)
    done = done and not info.get("TimeLimit.truncated", False)
    (info,) = inner.get_info()
    assert info["rgb"].shape == (512, 512, 3)
    steps += 1
    done = done or steps == 5
env.close()
""",
    # train.py of IDAAC, DrAC and train-procgen-pytorch: baselines' wrappers, by their attributes.
    "idaac": """
from procgen import ProcgenEnv
class VecEnvWrapper:
    def __init__(self, venv, observation_space=None):
        self.venv, self.num_envs = venv, venv.num_envs
        self.observation_space = observation_space or venv.observation_space
        self.action_space = venv.action_space
    def reset(self):
        return self.venv.reset()["rgb"]
    def step(self, actions):
        self.venv.step_async(actions)
        observations, rewards, dones, infos = self.venv.step_wait()
        return observations["rgb"], rewards, dones, infos
venv = ProcgenEnv(num_envs=8, env_name="bigfish", num_levels=200, start_level=0,
                  distribution_mode="easy", num_threads=4)
venv = VecEnvWrapper(venv, venv.observation_space.spaces["rgb"])
assert venv.reset().shape == (8, *venv.observation_space.shape)
for _ in range(200):
    observations, rewards, dones, infos = venv.step(np.random.randint(0, venv.action_space.n, 8))
    assert all(info["level_seed"] < 200 for info in infos)
""",
    # phasic_policy_gradient/envs.py: gym3's interface.
    "ppg": """
from procgen import ProcgenGym3Env
env = ProcgenGym3Env(num=4, env_name="coinrun", num_levels=0, start_level=0,
                     distribution_mode="hard")
assert env.ac_space.eltype.n == 15
for _ in range(3):
    env.act(np.full(env.num, 7, np.int32))
    rewards, observations, first = env.observe()
    assert observations["rgb"].shape == (4, 64, 64, 3)
assert {"prev_level_seed", "prev_level_complete", "level_seed"} <= set(env.get_info()[0])
""",
    # vec_env/procgen.py of rl-algo-impls.
    "rl-algo-impls": """
from procgen.env import ProcgenEnv, ProcgenGym3Env, ToBaselinesVecEnv
envs = ToBaselinesVecEnv(ProcgenGym3Env(3, "starpilot", rand_seed=1, render_mode="rgb_array"))
assert envs.reset()["rgb"].shape == (3, 64, 64, 3)
assert envs.step(np.array([4, 4, 4]))[3][0]["rgb"].shape == (512, 512, 3)
""",
    # online/ of gen_dgrl: the names of the games from the module.
    "gen_dgrl": """
import procgen
import procgen.env
venvs = [procgen.ProcgenEnv(num_envs=1, env_name=name) for name in procgen.env.ENV_NAMES[:2]]
assert [venv.reset()["rgb"].shape for venv in venvs] == [(1, 64, 64, 3)] * 2
""",
    # level-replay: a sampler chooses the next level of each environment whose episode ended.
    "level-replay": """
from procgen import ProcgenEnv
venv = ProcgenEnv(num_envs=4, env_name="bigfish", num_levels=1, start_level=0,
                  distribution_mode="easy")
venv.reset()
observations = venv.set_levels({0: 9, 1: 8, 2: 9})["rgb"]
np.testing.assert_array_equal(observations[0], observations[2])
assert (observations[0] != observations[1]).any()
observations, rewards, dones, infos = venv.step(np.array([4, -1, 4, 4]))
assert dones.tolist() == [False, True, False, False]
observations = venv.set_levels({1: 9})["rgb"]
infos = venv.step(np.array([4, 4, 4, 4]))[3]
assert [info["level_seed"] for info in infos] == [9, 9, 9, 0]
""",
    # generate_coinrun_dataset.py of jasmine: an environment for each episode, none of which is
    # closed, and frames from observe.
    "jasmine": """
import warnings
from procgen import ProcgenGym3Env
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    for episode in range(20):
        env = ProcgenGym3Env(num=1, env_name="coinrun", start_level=episode)
        frames = [env.observe()[1]["rgb"]]
        for _ in range(10):
            env.act(np.array([7]))
            rewards, observations, first = env.observe()
            frames.append(observations["rgb"])
assert np.concatenate(frames).shape == (11, 64, 64, 3)
assert "start_level is 1, but num_levels is 0" in str(caught[0].message)
""",
    # envs/procgen_env_wrapper.py of RLlib's starter kit: a gym.Env over gym.make.
    "rllib": """
import gym
from procgen.env import ENV_NAMES
class ProcgenEnvWrapper(gym.Env):
    def __init__(self, config):
        name = config.pop("env_name")
        assert name in ENV_NAMES
        self.env = gym.make(f"procgen:procgen-{name}-v0", **config)
        self.metadata = self.env.metadata
        self.observation_space = self.env.observation_space
        self.action_space = self.env.action_space
        self.done = True
    def reset(self):
        assert self.done
        self.done = False
        return self.env.reset()
    def step(self, action):
        observation, reward, self.done, info = self.env.step(action)
        return observation, reward, self.done, info
env = ProcgenEnvWrapper({
    "env_name": "maze", "num_levels": 1, "start_level": 3, "paint_vel_info": True,
    "use_generated_assets": False, "center_agent": True, "use_sequential_levels": False,
    "distribution_mode": "easy"})
first = env.reset()
assert env.step(4)[3]["level_seed"] == 3
assert env.step(-1)[2]
assert env.reset().shape == first.shape == (64, 64, 3)
""",
    # pufferlib/environments/procgen/environment.py: Gym's wrappers over ProcgenEnv, and a walk down
    # to get_info.
    "pufferlib": """
import gym
import gym.wrappers
import procgen
envs = procgen.ProcgenEnv(env_name="bigfish", num_envs=1, num_levels=0, start_level=0,
                          distribution_mode="easy", render_mode="rgb_array")
envs = gym.wrappers.TransformObservation(envs, lambda observation: observation["rgb"])
envs.single_action_space = envs.action_space
envs.single_observation_space = envs.observation_space["rgb"]
envs.is_vector_env = True
envs = gym.wrappers.RecordEpisodeStatistics(envs)
assert isinstance(envs.single_action_space, gym.spaces.Discrete)
assert envs.reset().shape == (1, 64, 64, 3)
observations, rewards, dones, infos = envs.step(np.array([-1]))
assert infos[0]["episode"]["r"] == rewards[0] and dones[0]
assert envs.env.env.env.get_info()[0]["rgb"].shape == (512, 512, 3)
""",
    "gymnasium": """
import gymnasium
env = gymnasium.make("procgen:procgen-coinrun-v0", num_levels=1, start_level=7)
observation, infos = env.reset(seed=0)
assert observation in env.observation_space and infos["level_seed"] == 7
env = gymnasium.make_vec("procgen:procgen-coinrun-v0", num_envs=3, distribution_mode="easy")
assert env.reset(seed=0)[0] in env.observation_space
""",
    # Upstream, gym_registration.py: one environment, with the observation alone; the observation of
    # the step that ends an episode is the one before it, and resets within one are ignored.
    "gym environment": """
import gym
import procgen
import warnings
env = gym.make("procgen:procgen-maze-v0", distribution_mode="easy", rand_seed=1).unwrapped
assert isinstance(env, gym.Env)
env.reset()
observation, reward, done, info = env.step(4)
assert (type(reward), done) == (float, False)
last, _, done, info = env.step(-1)
assert done and set(info) == {"prev_level_seed", "prev_level_complete", "level_seed"}
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
try:
    gym.make("procgen-maze-v0", render_mode="human")
except ValueError as error:
    assert "no window" in str(error)
else:
    raise AssertionError("render_mode='human' is not rejected")
""",
    # Programs that import this client before Gym.
    "order of imports": """
import procgen_client
import procgen
import gym
assert procgen.ProcgenEnv is procgen_client.ProcgenEnv
assert isinstance(procgen.ProcgenEnv(1, "maze").action_space, gym.spaces.Discrete)
assert gym.make("procgen:procgen-maze-v0").reset().shape == (64, 64, 3)
assert gym.make("procgen_client:procgen-maze-v0").reset().shape == (64, 64, 3)
assert gym.make("procgen-maze-v0").reset().shape == (64, 64, 3)
""",
}
_EXAMPLES = re.findall(r"^```python\n(.*?)^```$", (_PACKAGE / "README.md").read_text(), re.S | re.M)
_PROGRAMS |= {f"README {i}": example for i, example in enumerate(_EXAMPLES)}


@pytest.mark.parametrize("name", _PROGRAMS)
def test_program_runs(name: str, tmp_path: Path) -> None:
    if name == "gymnasium":
        pytest.importorskip("gymnasium")
    if name in ("pufferlib", "gym environment") and _gym_is_new():
        pytest.skip("wrappers of Gym 0.26 take other environments than upstream's, too")
    variables = dict(os.environ)
    if importlib.util.find_spec("gym") is None:
        variables = write_gym(tmp_path)
    path = os.pathsep.join([variables["PYTHONPATH"], str(_PACKAGE)])
    run = subprocess.run(
        [sys.executable, "-c", "import numpy as np\n" + _PROGRAMS[name]],
        env=variables | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
    )
    assert run.returncode == 0, run.stderr


def _gym_is_new() -> bool:
    with contextlib.suppress(metadata.PackageNotFoundError):
        return metadata.version("gym") >= "0.26"
    return False
