"""Programs for upstream and Gym, Gymnasium's predecessor, run with this client.

Debian has no Gym, so a stub package replaces it in a second Python process, as in
gymnasium_test.py. The program is in the manner of CleanRL's ppo_procgen.py, which is written for
Gym 0.23; its wrappers are gym/wrappers/ in brief.
"""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest
from stub_gym import write_gym

from procgen_client import ServerProcess

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
assert set(info) == {"prev_level_seed", "prev_level_complete", "level_seed"}
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
    result = subprocess.run(
        [sys.executable, "-c", _CLEANRL, server.address],
        env=write_gym(tmp_path),
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr


def test_spaces_are_those_of_gym_if_the_program_imports_it_later(tmp_path: Path) -> None:
    program = """
import procgen_client
env = procgen_client.ProcgenEnv(1, "maze")
import gym
assert isinstance(env.action_space, gym.spaces.Discrete), type(env.action_space)
assert isinstance(env.observation_space, gym.spaces.Dict), type(env.observation_space)
"""
    if importlib.util.find_spec("gymnasium") is not None:
        pytest.skip("where Gymnasium is installed, spaces are Gymnasium's")
    result = subprocess.run(
        [sys.executable, "-c", program],
        env=write_gym(tmp_path),
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
