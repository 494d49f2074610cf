"""Gymnasium's own classes, ids, wrappers and vector environments with these environments."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium", minversion="1.1")

from gymnasium import spaces  # noqa: E402
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv  # noqa: E402
from gymnasium.vector.utils import batch_space  # noqa: E402
from gymnasium.wrappers.vector import RecordEpisodeStatistics  # noqa: E402

from procgen_client import AutoresetMode, ProcgenEnv, ProcgenGymEnv, ProcgenVectorEnv  # noqa: E402

_N = 5
_OPTIONS = {"distribution_mode": "easy"}
# With SAME_STEP Gymnasium has them in final_info only.
_ALSO_BESIDE_FINAL_INFO = {"episode_return", "episode_length"}


def test_classes_and_spaces_are_gymnasiums() -> None:
    assert AutoresetMode is gymnasium.vector.AutoresetMode
    assert issubclass(ProcgenVectorEnv, gymnasium.vector.VectorEnv)
    assert issubclass(ProcgenGymEnv, gymnasium.Env)
    atari = {"screen_size": 84, "grayscale_obs": True, "frame_stack": 4}
    for options, shape in (({}, (64, 64, 3)), (atari, (4, 84, 84, 1))):
        box, discrete = spaces.Box(0, 255, shape, np.uint8), spaces.Discrete(15)
        with ProcgenVectorEnv("maze", 2, **options) as env:
            assert env.single_observation_space == box
            assert env.single_action_space == discrete
            assert env.observation_space == batch_space(box, 2)
            assert env.action_space == batch_space(discrete, 2)
            assert env.observation_space.contains(env.reset(seed=1)[0])
    venv = ProcgenEnv(1, "maze")
    assert isinstance(venv.observation_space, spaces.Dict)
    venv.close()


def test_ids_make_environments() -> None:
    vector = gymnasium.make_vec("procgen_server/coinrun-v0", num_envs=3)
    assert isinstance(vector, ProcgenVectorEnv)
    assert (vector.pool.games, vector.num_envs) == (("coinrun",), 3)
    vector.close()
    one = gymnasium.make("procgen_client:procgen-maze-v0", render_mode="rgb_array")
    assert isinstance(one.unwrapped, ProcgenGymEnv)
    one.reset(seed=5)
    assert one.unwrapped.np_random_seed == 5
    one.step(4)
    assert one.render().shape == (512, 512, 3)
    one.close()


@pytest.mark.parametrize(
    ("game", "limit", "options"),
    [
        ("maze", 500, {}),
        ("bigfish", 6000, {}),
        ("jumper", 2000, {"distribution_mode": "memory"}),
        ("coinrun", 250, {"frame_skip": 4}),
    ],
)
def test_the_spec_has_the_time_limit(game: str, limit: int, options: dict[str, Any]) -> None:
    with gymnasium.make(f"procgen_server/{game}-v0", **options) as env:
        assert env.unwrapped.spec.max_episode_steps == limit


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_record_episode_statistics_counts_each_episode(mode: AutoresetMode) -> None:
    with ProcgenVectorEnv("bigfish", _N, autoreset_mode=mode) as inner:
        env = RecordEpisodeStatistics(inner)
        env.reset(seed=1)
        for t in range(40):
            actions = np.where(np.arange(_N) == t % _N, -1, 4)
            _, _, terminations, truncations, infos = env.step(actions)
            ended = terminations | truncations
            if mode is not AutoresetMode.SAME_STEP:  # It counts that step to the next episode.
                np.testing.assert_array_equal(infos["episode"]["l"], infos["episode_length"])
            np.testing.assert_array_equal(infos["episode"]["r"], infos["episode_return"])
            if mode is AutoresetMode.DISABLED:
                env.reset(options={"reset_mask": ended})


def test_workers_of_an_async_vector_env_step_while_the_parent_does() -> None:
    with ProcgenVectorEnv("coinrun", 4) as other:
        other.reset()
        for _ in range(2):
            env = AsyncVectorEnv([lambda: ProcgenGymEnv("maze", rand_seed=3)] * 3)
            other.step(np.full(4, 7))
            env.reset(seed=1)
            for _ in range(5):
                observations, *_ = env.step(np.full(3, 3))
                other.step(np.full(4, 7))
            assert observations.shape == (3, 64, 64, 3)
            assert observations.any()
            env.close()


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_infos_equal_those_of_a_sync_vector_env(mode: AutoresetMode) -> None:
    makers = [lambda: ProcgenGymEnv("bigfish", **_OPTIONS)] * _N
    sync = SyncVectorEnv(makers, autoreset_mode=mode)
    own = ProcgenVectorEnv("bigfish", _N, autoreset_mode=mode, **_OPTIONS)
    may_have = _ALSO_BESIDE_FINAL_INFO if mode is AutoresetMode.SAME_STEP else set()
    _assert_equal(own.reset(seed=3)[1], sync.reset(seed=3)[1], set())
    rng, end_count = np.random.default_rng(0), 0
    for _ in range(150):
        actions = rng.integers(0, 15, _N)
        # -1 is outside of the action space, but SyncVectorEnv passes it to the environments.
        actions[rng.random(_N) < 0.05] = -1
        step, theirs = own.step(actions), sync.step(actions)
        ended = step[2] | step[3]
        np.testing.assert_array_equal(ended, theirs[2] | theirs[3])
        _assert_equal(step[-1], theirs[-1], may_have)
        end_count += np.count_nonzero(ended)
        if mode is AutoresetMode.DISABLED and ended.any():
            # SyncVectorEnv removes reset_mask from its options.
            options = [{"reset_mask": ended, "level_seed": 9} for _ in range(2)]
            _assert_equal(
                own.reset(options=options[0])[1], sync.reset(options=options[1])[1], set()
            )
    assert end_count > 20
    own.close()
    sync.close()


def _assert_equal(own: dict[str, Any], theirs: dict[str, Any], may_have: set[str]) -> None:
    surplus = {key.removeprefix("_") for key in own.keys() - theirs.keys()}
    assert theirs.keys() <= own.keys()
    assert surplus <= may_have
    for key, value in theirs.items():
        if isinstance(value, dict):
            _assert_equal(own[key], value, set())
            continue
        assert own[key].dtype == value.dtype, key
        if value.dtype == object:  # Frames, or None.
            for left, right in zip(own[key], value, strict=True):
                np.testing.assert_array_equal(left, right, err_msg=key)
        else:
            np.testing.assert_array_equal(own[key], value, err_msg=key)
