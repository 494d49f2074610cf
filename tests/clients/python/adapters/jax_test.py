"""A pool steps within jitted programs, in order, with the pool's values."""

from __future__ import annotations

import numpy as np
import pytest

jax = pytest.importorskip("jax")

from procgen_client import Pool, errors  # noqa: E402
from procgen_client.adapters.jax import ProcgenJaxEnv, TimeStep  # noqa: E402

_N, _STEPS = 4, 30
_OPTIONS = {"distribution_mode": "easy", "rand_seed": 3}


def test_a_jitted_rollout_equals_a_pools() -> None:
    env = ProcgenJaxEnv("coinrun", _N, **_OPTIONS)

    @jax.jit
    def rollout(actions: jax.Array) -> tuple[TimeStep, TimeStep]:
        first = env.observe()
        _, steps = jax.lax.scan(lambda carry, each: (carry, env.step(each)), None, actions)
        return first, steps

    actions = np.arange(_STEPS * _N).reshape(_STEPS, _N) % 15
    actions[10, 1] = -1
    first, steps = rollout(actions)
    with Pool("coinrun", _N, **_OPTIONS) as pool:
        np.testing.assert_array_equal(first.observation, pool.observe().observations)
        for t in range(_STEPS):
            batch = pool.step(actions[t])
            np.testing.assert_array_equal(steps.observation[t], batch.observations)
            np.testing.assert_array_equal(steps.reward[t], batch.rewards)
            np.testing.assert_array_equal(steps.terminated[t], batch.terminated)
            np.testing.assert_array_equal(steps.truncated[t], batch.truncated)
            np.testing.assert_array_equal(steps.level_seed[t], batch.level_seeds)
    assert steps.observation.dtype == np.uint8
    assert steps.terminated[10].tolist() == [False, True, False, False]
    env.close()


def test_equal_seeds_reset_to_equal_levels() -> None:
    env = ProcgenJaxEnv("maze", _N, distribution_mode="easy")
    reset = jax.jit(env.reset)
    one, other = reset(5), reset(6)
    np.testing.assert_array_equal(reset(5).level_seed, one.level_seed)
    assert (one.level_seed != other.level_seed).any()
    assert not np.asarray(env.reset().terminated).any()
    env.close()


def test_wrong_actions_are_errors() -> None:
    env = ProcgenJaxEnv("maze", _N)
    with pytest.raises(Exception, match="action 15 of environment 0"):
        jax.block_until_ready(env.step(np.full(_N, 15)))
    env.close()
    with pytest.raises(errors.NotFoundError):
        ProcgenJaxEnv("pong")
