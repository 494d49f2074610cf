"""Stable-Baselines3 trains on the adapter, and gets the values of a pool."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

from stable_baselines3 import A2C, DQN, PPO  # noqa: E402
from stable_baselines3.common.evaluation import evaluate_policy  # noqa: E402
from stable_baselines3.common.vec_env import (  # noqa: E402
    VecExtractDictObs,
    VecMonitor,
    VecNormalize,
)

from procgen_client import Pool, ProcgenEnv, errors  # noqa: E402
from procgen_client.adapters.stable_baselines3 import ProcgenVecEnv  # noqa: E402

_N = 4
_OPTIONS = {"distribution_mode": "easy", "rand_seed": 3}


@pytest.fixture
def env() -> Iterator[ProcgenVecEnv]:
    """Environments with a stack of two frames."""
    made = ProcgenVecEnv("coinrun", _N, frame_stack=2, **_OPTIONS)
    yield made
    made.close()


def test_frames_are_stacked_in_the_channels(env: ProcgenVecEnv) -> None:
    with Pool("coinrun", _N, layout="chw", **_OPTIONS) as pool:
        frames = [pool.observe().observations]
        observations = env.reset()
        np.testing.assert_array_equal(observations, np.concatenate(frames * 2, axis=1))
        for action in (7, 5, 7):
            observations, rewards, dones, infos = env.step(np.full(_N, action))
            batch = pool.step([action] * _N)
            frames.append(batch.observations)
            np.testing.assert_array_equal(observations, np.concatenate(frames[-2:], axis=1))
            np.testing.assert_array_equal(rewards, batch.rewards)
            assert [info["level_seed"] for info in infos] == batch.level_seeds.tolist()
            assert not dones.any()
    assert observations.shape == (_N, *env.observation_space.shape) == (_N, 6, 64, 64)


def test_infos_of_an_ended_episode(env: ProcgenVecEnv) -> None:
    before = env.reset()
    observations, rewards, dones, infos = env.step(np.array([4, -1, 4, 4]))
    assert dones.tolist() == [False, True, False, False]
    assert "episode" not in infos[0]
    assert infos[1]["TimeLimit.truncated"] is False
    assert (infos[1]["episode"]["r"], infos[1]["episode"]["l"]) == (0, 1)
    assert 0 <= infos[1]["episode"]["t"] < 600
    assert infos[1]["terminal_observation"].shape == (6, 64, 64)
    np.testing.assert_array_equal(infos[1]["terminal_observation"][:3], before[1, 3:])
    np.testing.assert_array_equal(observations[1, :3], observations[1, 3:])


def test_seeds_and_levels(env: ProcgenVecEnv) -> None:
    def levels() -> list[int]:
        env.reset()
        return [info["level_seed"] for info in env.reset_infos]

    env.seed(11)
    one, another = levels(), levels()
    env.seed(11)
    assert levels() == one != another
    env.set_options({"level_seed": 5})
    assert levels() == [5] * _N
    env.set_options({"level": 5})
    with pytest.raises(errors.InvalidArgumentError, match="did you mean 'level_seed'"):
        env.reset()


@pytest.mark.parametrize("algorithm", [PPO, A2C, DQN])
def test_algorithms_learn_and_save(
    algorithm: type, env: ProcgenVecEnv, tmp_path: Path
) -> None:
    few = {PPO: {"n_steps": 16, "batch_size": 32}, A2C: {}, DQN: {"buffer_size": 200}}[algorithm]
    model = algorithm("CnnPolicy", env, seed=1, **few)
    model.learn(128)
    model.save(tmp_path / "model")
    loaded = algorithm.load(tmp_path / "model", env)
    observations = env.reset()
    expected, _ = model.predict(observations, deterministic=True)
    np.testing.assert_array_equal(loaded.predict(observations, deterministic=True)[0], expected)


def test_values_are_bootstrapped_at_the_time_limit() -> None:
    # on_policy_algorithm.py, collect_rollouts: reward += gamma * value(terminal_observation).
    rewards = {}
    for gamma in (0.0, 0.5):
        env = ProcgenVecEnv("maze", 1, num_levels=1, **_OPTIONS)
        env.reset()
        for _ in range(490):  # Of 500.
            env.step(np.array([4]))
        env.reset = lambda env=env: env._observations_of(env.pool.observe().observations)
        model = A2C("CnnPolicy", env, n_steps=16, gamma=gamma, seed=1, learning_rate=0.0)
        model.policy.action_net.bias.data[4] = 1e9  # It stands still.
        model.learn(16)
        (at,) = np.flatnonzero(model.rollout_buffer.episode_starts.ravel()[1:])
        rewards[gamma] = model.rollout_buffer.rewards[at, 0]
        env.close()
    assert rewards[0.0] == 0
    assert rewards[0.5] != 0


def test_wrappers_and_evaluation(env: ProcgenVecEnv) -> None:
    model = PPO("CnnPolicy", VecNormalize(env, norm_obs=False), n_steps=8, batch_size=32)
    model.learn(32)
    returns, lengths = evaluate_policy(
        model, env, n_eval_episodes=2, return_episode_rewards=True, warn=True
    )
    assert len(returns) == len(lengths) >= 2
    assert env.render() is None
    shown = ProcgenVecEnv("coinrun", 1, render_mode="rgb_array", **_OPTIONS)
    assert shown.render().shape == (512, 512, 3)
    with pytest.raises(errors.UnimplementedError, match="'close'"):
        shown.env_method("close")
    shown.close()


def test_procgen_env_passes_through_its_wrappers_too() -> None:
    venv = VecMonitor(VecExtractDictObs(ProcgenEnv(_N, "coinrun", **_OPTIONS), "rgb"))
    PPO("CnnPolicy", venv, n_steps=16, batch_size=32).learn(64)
    *_, infos = venv.step(np.full(_N, -1))
    assert infos[0]["terminal_observation"].shape == (64, 64, 3)
    venv.close()
