"""Gymnasium's contract of environments, with the source of each rule.

Sources are modules of Gymnasium 1.4.0, which is not needed here.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from procgen_client import Client, ProcgenGymEnv, ProcgenVectorEnv, errors


@pytest.fixture
def env() -> Iterator[ProcgenGymEnv]:
    """One environment."""
    with ProcgenGymEnv("maze", distribution_mode="easy", rand_seed=3) as made:
        yield made


def test_reset_and_step_follow_the_gymnasium_api(env: ProcgenGymEnv) -> None:
    # core.py, Env.reset: (obs, info); Env.step: (obs, float, bool, bool, dict).
    observation, infos = env.reset()
    assert observation in env.observation_space
    assert set(infos) == {"level_seed"}
    assert isinstance(infos["level_seed"], int)
    for action in (3, np.int64(4), env.action_space.sample()):
        observation, reward, terminated, truncated, infos = env.step(action)
        assert observation in env.observation_space
        assert observation.flags.writeable
        assert set(infos) == {"level_seed", "prev_level_seed", "prev_level_complete"}
        assert [type(value) for value in (reward, terminated, truncated)] == [float, bool, bool]
    with pytest.raises(TypeError):
        env.reset(0)  # seed and options are keyword-only


def test_ended_episode_requires_a_reset(env: ProcgenGymEnv) -> None:
    # core.py, Env.step: after terminated or truncated the user calls reset.
    env.reset()
    _, _, terminated, truncated, infos = env.step(-1)
    assert (terminated, truncated) == (True, False)
    assert infos["episode_length"] == 1
    with pytest.raises(errors.FailedPreconditionError, match="call reset"):
        env.step(4)
    env.reset()
    _, _, _, _, infos = env.step(4)
    assert "episode_length" not in infos


def test_gym_env_equals_a_vector_environment_of_one(env: ProcgenGymEnv) -> None:
    # Ours: no source in Gymnasium.
    with ProcgenVectorEnv(
        "maze", 1, distribution_mode="easy", rand_seed=3
    ) as vector:
        left, _ = env.reset()
        right, _ = vector.reset()
        for action in range(15):
            np.testing.assert_array_equal(left, right[0])
            left, reward, *_ = env.step(action)
            right, rewards, *_ = vector.step([action])
            assert reward == rewards[0]


def test_states_are_restored_and_levels_can_be_chosen(env: ProcgenGymEnv) -> None:
    # Ours: no source in Gymnasium.
    _, infos = env.reset(options={"level_seed": 42})
    assert infos["level_seed"] == 42
    state = env.save_state()
    before = env.step(4)
    env.step(-1)
    observation, infos = env.restore_state(state)
    assert infos["level_seed"] == 42
    after = env.step(4)
    np.testing.assert_array_equal(before[0], after[0])
    assert before[1:] == after[1:]


def test_render_and_close(client: Client, env: ProcgenGymEnv) -> None:
    # core.py, Env.render: a frame with "rgb_array", None without a mode; close may come twice.
    assert env.render() is None
    before = len(client.list_pools())
    one = ProcgenGymEnv("maze", render_mode="rgb_array", render_size_px=96)
    one.reset()
    assert one.render().shape == (96, 96, 3)
    assert one.unwrapped is one
    one.close()
    one.close()
    assert len(client.list_pools()) == before
    with pytest.raises(errors.InvalidArgumentError, match="one environment plays one game"):
        ProcgenGymEnv(["maze", "coinrun"])
    with pytest.raises(errors.NotFoundError):
        ProcgenGymEnv("pong")
