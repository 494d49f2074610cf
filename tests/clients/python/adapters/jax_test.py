"""A pool steps within jitted programs, in order, with the pool's values."""

from __future__ import annotations

import gc
import os
import subprocess
import sys

import numpy as np
import pytest

jax = pytest.importorskip("jax")

from procgen_client import Pool, errors  # noqa: E402
from procgen_client.adapters.jax import ProcgenJaxEnv  # noqa: E402

_N, _STEPS = 4, 30
_OPTIONS = {"distribution_mode": "easy", "rand_seed": 3}


@pytest.mark.parametrize("is_xla", [False, True])
def test_a_jitted_rollout_equals_a_pools(is_xla: bool) -> None:
    env = ProcgenJaxEnv("coinrun", _N, **_OPTIONS)
    first = jax.jit(env.observe)()
    handle, step = env.xla() if is_xla else (None, lambda _, each: (_, env.step(each)))
    rollout = jax.jit(lambda handle, actions: jax.lax.scan(step, handle, actions))
    actions = np.arange(_STEPS * _N).reshape(_STEPS, _N) % 15
    actions[10, 1] = -1
    handle, _ = rollout(handle, actions)
    _, steps = rollout(handle, actions)
    with Pool("coinrun", _N, **_OPTIONS) as pool:
        np.testing.assert_array_equal(first.observation, pool.observe().observations)
        for each in actions:
            pool.step(each, observe=False)
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


def test_an_xla_step_needs_the_newest_handle() -> None:
    env = ProcgenJaxEnv("maze", _N)
    handle, step = env.xla()
    step = jax.jit(step)
    following, _ = step(handle, np.zeros(_N, int))
    with pytest.raises(Exception, match="after step 0, but 1 steps were taken: give each step"):
        jax.block_until_ready(step(handle, np.zeros(_N, int)))
    assert env.xla()[0] == following == 1
    env.close()


def test_errors_of_an_xla_step_change_nothing() -> None:
    env = ProcgenJaxEnv("maze", _N)
    handle, step = env.xla()
    with pytest.raises(errors.InvalidArgumentError, match="one integer for each of 4 environments"):
        step(handle, np.zeros(_N + 1, int))
    with pytest.raises(Exception, match="INVALID_ARGUMENT: action 15 of environment 0"):
        jax.block_until_ready(jax.jit(step)(handle, np.full(_N, 15)))
    step(handle, np.zeros(_N, int))
    env.close()


@pytest.mark.parametrize("end", ["env.close()", "env.pool.close()", "del env, step; gc.collect()"])
def test_a_compiled_program_outlives_its_pool(end: str) -> None:
    env = ProcgenJaxEnv("maze", _N)
    handle, step = env.xla()
    actions = np.zeros(_N, np.int32)
    compiled = jax.jit(step).lower(handle, actions).compile()
    jax.clear_caches()  # They refer to the environments.
    scope = {"env": env, "step": step, "gc": gc}
    del env, step
    exec(end, scope)
    with pytest.raises(Exception, match="the pool is closed"):
        jax.block_until_ready(compiled(handle, actions))


def test_xla_names_a_missing_compiler() -> None:
    program = "from procgen_client.adapters.jax import *; ProcgenJaxEnv('maze', 1).xla()"
    run = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "CC": "/missing/cc"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert "xla() needs a C compiler: install cc" in run.stderr


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
