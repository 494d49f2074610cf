"""PufferLib's vectorisations step the adapter, with the values of a pool."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("pufferlib")

import pufferlib.vector  # noqa: E402

from procgen_client import Pool, errors  # noqa: E402
from procgen_client.adapters.pufferlib import ProcgenPufferEnv  # noqa: E402

_N = 4
_OPTIONS = {"distribution_mode": "easy", "rand_seed": 3}
_ARGUMENTS = {"games": "coinrun", "num_envs": _N, **_OPTIONS}


def test_values_are_those_of_a_pool_in_the_librarys_memory() -> None:
    env = pufferlib.vector.make(ProcgenPufferEnv, env_kwargs=_ARGUMENTS)
    memory = env.observations
    with Pool("coinrun", _N, **_OPTIONS) as pool:
        observations, infos = env.reset()
        batch = pool.reset()
        np.testing.assert_array_equal(observations, batch.observations)
        assert infos == []
        for actions in ([7, 7, 7, 7], [4, -1, 4, 4], [5, 7, 5, 7]):
            observations, rewards, terminals, truncations, infos = env.step(np.array(actions))
            batch = pool.step(actions)
            np.testing.assert_array_equal(observations, batch.observations)
            np.testing.assert_array_equal(rewards, batch.rewards)
            np.testing.assert_array_equal(terminals, batch.terminated)
            np.testing.assert_array_equal(truncations, batch.truncated)
            assert [info["episode_length"] for info in infos] == [2] * (-1 in actions)
    assert observations is memory
    env.close()


@pytest.mark.parametrize("backend", [pufferlib.vector.Serial, pufferlib.vector.Multiprocessing])
def test_other_vectorisations_step_it(backend: type) -> None:
    several = {"num_workers": 2} if backend is pufferlib.vector.Multiprocessing else {}
    env = pufferlib.vector.make(
        ProcgenPufferEnv, env_kwargs=_ARGUMENTS | {"num_threads": 0}, backend=backend, num_envs=2,
        **several,
    )  # fmt: skip
    env.async_reset(seed=0)
    for _ in range(20):
        observations, rewards, *_ = env.recv()
        env.send(np.random.randint(0, 15, 2 * _N))
    assert observations.shape == (2 * _N, 64, 64, 3)
    assert observations.any(axis=(1, 2, 3)).all()
    env.recv()
    env.close()


def test_equal_seeds_reset_to_equal_levels() -> None:
    env = ProcgenPufferEnv("maze", _N)
    one, _ = env.reset(seed=5)
    one = one.copy()
    other, _ = env.reset(seed=6)
    assert (one != other).any()
    np.testing.assert_array_equal(one, env.reset(seed=5)[0])
    env.close()
    with pytest.raises(errors.InvalidArgumentError, match="did you mean 'num_levels'"):
        ProcgenPufferEnv("maze", num_level=5)
