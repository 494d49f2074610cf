"""Gymnasium before 1.1, whose vector environments have another contract."""

from __future__ import annotations

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")
if hasattr(gymnasium.vector, "AutoresetMode"):
    pytest.skip("Gymnasium is 1.1 or later", allow_module_level=True)

from gymnasium.utils.env_checker import check_env  # noqa: E402
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv  # noqa: E402
from gymnasium.wrappers import RecordEpisodeStatistics, TimeLimit  # noqa: E402

from procgen_client import AutoresetMode, ProcgenGymEnv, ProcgenVectorEnv  # noqa: E402

_OPTIONS = {"distribution_mode": "easy", "rand_seed": 3}


def test_ids_make_environments_that_pass_gymnasiums_check() -> None:
    for env_id in ("procgen_server/coinrun-v0", "procgen_client:procgen-coinrun-v0"):
        env = gymnasium.make(env_id, render_mode="rgb_array", **_OPTIONS)
        assert isinstance(env.unwrapped, ProcgenGymEnv)
        assert isinstance(env.unwrapped, gymnasium.Env)
        check_env(env.unwrapped, skip_render_check=True)
        env.reset()
        assert env.render().shape == (512, 512, 3)
        env.close()


def test_wrappers_count_the_steps_of_an_episode() -> None:
    env = RecordEpisodeStatistics(TimeLimit(ProcgenGymEnv("maze", **_OPTIONS), 10))
    env.reset(seed=1)
    for _ in range(10):
        _, _, _, truncated, info = env.step(4)
    assert truncated
    assert info["episode"]["l"] == 10
    env.close()


@pytest.mark.parametrize("vectorise", [SyncVectorEnv, AsyncVectorEnv])
def test_its_vector_environments_step_environments_of_one(vectorise: type) -> None:
    env = vectorise([lambda: ProcgenGymEnv("maze", **_OPTIONS)] * 2)
    env.reset(seed=[5, 6])
    observations, *_ = env.step(np.array([1, 7]))
    env.close()
    with ProcgenVectorEnv("maze", 2, autoreset_mode=AutoresetMode.SAME_STEP, **_OPTIONS) as own:
        own.reset(seed=5)
        np.testing.assert_array_equal(own.step(np.array([1, 7]))[0], observations)
