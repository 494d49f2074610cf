"""Ray: RLlib's runners, actors with slices of one pool, and servers beside a learner."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

ray = pytest.importorskip("ray")
pytest.importorskip("ray.rllib")

from ray.rllib.algorithms.ppo import PPOConfig  # noqa: E402
from ray.rllib.env.env_context import EnvContext  # noqa: E402
from ray.tune import register_env  # noqa: E402

from procgen_client import Pool, ProcgenVectorEnv  # noqa: E402
from procgen_client.adapters.rllib import make_env  # noqa: E402

_OPTIONS = {"games": "coinrun", "distribution_mode": "easy", "rand_seed": 3}


@pytest.fixture(scope="module", autouse=True)
def cluster() -> Iterator[None]:
    """Ray, on this machine."""
    ray.init(num_cpus=2, include_dashboard=False)
    yield
    ray.shutdown()


def test_runners_have_slices_of_one_pool() -> None:
    runners = [EnvContext({**_OPTIONS, "num_envs": 3}, worker_index=i) for i in (1, 2)]
    observations = [make_env(runner).reset()[0] for runner in runners]
    with Pool("coinrun", 6, distribution_mode="easy", rand_seed=3) as pool:
        expected = pool.observe().observations
    assert observations[0].dtype == np.float32
    np.testing.assert_allclose(np.concatenate(observations), expected / 255, atol=1e-6)


def test_one_environment_without_vectorisation() -> None:
    env = make_env(EnvContext(_OPTIONS, worker_index=2))
    observation, infos = env.reset()
    assert observation in env.observation_space
    with ProcgenVectorEnv(num_envs=2, **_OPTIONS) as vector:
        assert infos["level_seed"] == vector.reset()[1]["level_seed"][1]
    env.close()


def test_ppo_learns_in_a_pool_of_each_runner() -> None:
    register_env("procgen", make_env)
    config = (
        PPOConfig()
        .environment("procgen", env_config=_OPTIONS)
        .env_runners(
            num_env_runners=1,
            num_envs_per_env_runner=8,
            gym_env_vectorize_mode="vector_entry_point",
            rollout_fragment_length=16,
        )
        .training(train_batch_size_per_learner=128, minibatch_size=64, num_epochs=1)
    )
    algorithm = config.build_algo()
    result = algorithm.train()
    assert result["env_runners"]["num_env_steps_sampled"] == 128
    algorithm.stop()
