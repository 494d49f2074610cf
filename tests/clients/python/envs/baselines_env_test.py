"""ProcgenEnv and the names of upstream's module `procgen.env`, with the source of each rule.

Levels that start at once have no source upstream; programs for prioritised level replay use forks
that have them.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

import procgen_client.env
from procgen_client import (
    ProcgenEnv,
    ProcgenGym3Env,
    ProcgenVectorEnv,
    ToBaselinesVecEnv,
    errors,
)

_N = 4
_OPTIONS = {"distribution_mode": "easy", "rand_seed": 7}


@pytest.fixture
def env() -> Iterator[ProcgenGym3Env]:
    """Four environments."""
    made = ProcgenGym3Env(_N, "coinrun", **_OPTIONS)
    yield made
    made.close()


def test_set_levels_starts_levels_at_once(env: ProcgenGym3Env) -> None:
    env.act([7] * _N)
    _, before, _ = env.observe()
    env.set_levels({1: 5, 3: 5})
    rewards, observations, first = env.observe()
    assert [info["level_seed"] for info in env.get_info()][1::2] == [5, 5]
    assert first.tolist() == [False, True, False, True]
    assert rewards[1::2].tolist() == [0, 0]
    np.testing.assert_array_equal(observations["rgb"][1], observations["rgb"][3])
    np.testing.assert_array_equal(observations["rgb"][::2], before["rgb"][::2])
    assert (observations["rgb"][1] != before["rgb"][1]).any()


def test_set_levels_within_a_step_follows_it(env: ProcgenGym3Env) -> None:
    env.act([7] * _N)
    env.set_levels({2: 11})
    env.act([7] * _N)
    twin = ProcgenGym3Env(_N, "coinrun", **_OPTIONS)
    for _ in range(2):
        twin.act([7] * _N)
    left, right = env.observe()[1]["rgb"], twin.observe()[1]["rgb"]
    np.testing.assert_array_equal(left[[0, 1, 3]], right[[0, 1, 3]])
    twin.close()


def test_baselines_set_levels_returns_fresh_observations() -> None:
    venv = ProcgenEnv(_N, "coinrun", **_OPTIONS)
    before = venv.reset()["rgb"]
    after = venv.set_levels({0: 7})["rgb"]
    assert (after[0] != before[0]).any()
    np.testing.assert_array_equal(after, venv.observe()["rgb"])
    np.testing.assert_array_equal(after[1:], before[1:])
    np.testing.assert_array_equal(venv.set_levels({})["rgb"], after)
    venv.close()


@pytest.mark.parametrize(
    ("levels", "message"),
    [
        ({4: 1}, r"environment is 4; it is in \[0, 3\]"),
        ({-1: 1}, r"environment is -1; it is in \[0, 3\]"),
        ({0: 2**31}, r"level_seeds\[0\] is 2147483648; it is in"),
        ({0: "5"}, r"level_seeds\[0\] is '5'; it is an integer in"),
    ],
)
def test_wrong_levels_are_rejected(
    env: ProcgenGym3Env, levels: dict[int, int], message: str
) -> None:
    with pytest.raises(errors.InvalidArgumentError, match=message):
        env.set_levels(levels)


def test_infos_have_the_last_observation_of_an_episode() -> None:
    # Stable-Baselines3 2.4, common/vec_env/dummy_vec_env.py: info["terminal_observation"], of the
    # kind of an observation, and info["TimeLimit.truncated"], where an episode ended.
    options = {"distribution_mode": "easy", "rand_seed": 7, "num_levels": 1}
    venv = ProcgenEnv(2, "maze", **options)
    with ProcgenVectorEnv("maze", 2, **options) as vector:  # Its ends show the last observation.
        venv.reset()
        for actions in ([7, 4], [-1, 4]):
            observations, _, dones, infos = venv.step(actions)
            expected, *_ = vector.step(actions)
    assert dones.tolist() == [True, False]
    assert infos[0]["TimeLimit.truncated"] is False
    np.testing.assert_array_equal(infos[0]["terminal_observation"]["rgb"], expected[0])
    assert (observations["rgb"][0] != expected[0]).any()
    assert not {"terminal_observation", "TimeLimit.truncated"} & infos[1].keys()
    while not dones[1]:
        *_, dones, infos = venv.step([4, 4])
    assert infos[1]["TimeLimit.truncated"] is True
    assert infos[1]["terminal_observation"]["rgb"].shape == (64, 64, 3)
    venv.close()


def test_swapped_arguments_are_explained() -> None:
    for env_class in (ProcgenEnv, ProcgenGym3Env):
        expected = rf"comes first: {env_class.__name__}\(4, 'coinrun'\)"
        with pytest.raises(errors.InvalidArgumentError, match=expected):
            env_class("coinrun", 4)


def test_options_are_a_dict(env: ProcgenGym3Env) -> None:
    # Upstream: ProcgenGym3Env.options, by upstream's names.
    assert env.options["env_name"] == "coinrun"
    assert env.options["rand_seed"] == 7
    assert (env.options["distribution_mode"], env.options["num_levels"]) == ("easy", 0)
    assert env.options["center_agent"] is True
    drawn = ProcgenGym3Env(1, "maze")
    assert drawn.options["rand_seed"] == drawn.pool.options["rand_seed"]
    drawn.close()


def test_negative_rand_seed_is_accepted_as_upstream() -> None:
    # Upstream: rand_seed is an int32.
    levels = []
    for rand_seed in (-1, 2**32 - 1):
        env = ProcgenGym3Env(2, "maze", rand_seed=rand_seed)
        levels.append([info["level_seed"] for info in env.get_info()])
        env.close()
    assert levels[0] == levels[1]


def test_module_env_has_upstreams_names() -> None:
    # Upstream: `from procgen.env import ENV_NAMES, ProcgenEnv, ProcgenGym3Env, ToBaselinesVecEnv`.
    for name in ("ENV_NAMES", "ProcgenEnv", "ProcgenGym3Env", "ToBaselinesVecEnv"):
        assert getattr(procgen_client.env, name) is getattr(procgen_client, name)


def test_to_baselines_vec_env_wraps_a_gym3_environment() -> None:
    # gym3: ToBaselinesVecEnv(env), the API of baselines' VecEnv. Upstream's ProcgenEnv is one.
    wrapped = ToBaselinesVecEnv(ProcgenGym3Env(_N, "coinrun", **_OPTIONS))
    venv = ProcgenEnv(_N, "coinrun", **_OPTIONS)
    np.testing.assert_array_equal(wrapped.reset()["rgb"], venv.reset()["rgb"])
    assert (wrapped.num_envs, wrapped.action_space.n) == (_N, 15)
    for action in (7, -1, 4):
        left, right = wrapped.step(np.full(_N, action)), venv.step(np.full(_N, action))
        np.testing.assert_array_equal(left[0]["rgb"], right[0]["rgb"])
        np.testing.assert_array_equal(left[1], right[1])
        np.testing.assert_array_equal(left[2], right[2])
        assert [info["level_seed"] for info in left[3]] == [info["level_seed"] for info in right[3]]
    venv.close()
    wrapped.close()


def test_closed_environments_say_so() -> None:
    env = ProcgenGym3Env(2, "maze")
    venv = ProcgenEnv(2, "maze")
    env.close()
    venv.close()
    calls = (env.observe, lambda: env.act([4, 4]), env.get_state, venv.reset, venv.observe)
    for call in (*calls, lambda: venv.step([4, 4]), lambda: venv.set_levels({0: 1})):
        with pytest.raises(errors.FailedPreconditionError, match="the environments are closed"):
            call()
