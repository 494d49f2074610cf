"""dm_env's own test battery, and values of a pool."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("dm_env")

import dm_env  # noqa: E402
from absl.testing import absltest  # noqa: E402
from dm_env import test_utils  # noqa: E402

from procgen_client import Pool, errors  # noqa: E402
from procgen_client.adapters.dm_env import ProcgenDmEnv  # noqa: E402

_OPTIONS = {"distribution_mode": "easy", "rand_seed": 3}


class TestConformance(test_utils.EnvironmentTestMixin, absltest.TestCase):
    """dm_env.test_utils: types and order of time steps, specs."""

    def make_object_under_test(self) -> dm_env.Environment:
        return ProcgenDmEnv("coinrun", **_OPTIONS)

    def make_action_sequence(self) -> list[int]:
        return [7, 4, -1, 5, 8] * 20

    def test_action_of_spec(self) -> None:
        self.environment.reset()
        self.environment.step(self.environment.action_spec().generate_value())


def test_values_are_those_of_a_pool() -> None:
    env = ProcgenDmEnv("coinrun", **_OPTIONS)
    with Pool("coinrun", 1, **_OPTIONS) as pool:
        np.testing.assert_array_equal(env.reset().observation, pool.observe().observations[0])
        for action in (7, 7, 5, 4):
            time_step, batch = env.step(action), pool.step([action])
            np.testing.assert_array_equal(time_step.observation, batch.observations[0])
            assert time_step.reward == batch.rewards[0]
    env.close()


def test_discount_is_one_at_the_time_limit() -> None:
    env = ProcgenDmEnv("maze", num_levels=1, **_OPTIONS)
    env.reset()
    time_step = env.step(-1)
    assert (time_step.step_type, time_step.discount) == (dm_env.StepType.LAST, 0)
    assert env.step(4).first()
    while not time_step.last() or time_step.discount == 0:
        time_step = env.step(4)
    assert time_step.discount == 1
    env.close()


def test_levels_can_be_chosen_and_options_are_checked() -> None:
    env = ProcgenDmEnv("maze", **_OPTIONS)
    env.reset(level_seed=5)
    assert env.pool.observe().level_seeds[0] == 5
    env.close()
    with pytest.raises(errors.InvalidArgumentError, match="did you mean 'num_levels'"):
        ProcgenDmEnv("maze", num_level=5)
