"""Gymnasium's contract of vector environments, with the source of each rule.

Sources are modules of Gymnasium 1.4.0, which need not be installed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from procgen_client import AutoresetMode, Client, ProcgenVectorEnv, errors

_N = 4
_NOTHING = np.full(_N, 4)
_END_OF_FIRST = np.array([-1, 4, 4, 4])

MakeEnv = Callable[..., ProcgenVectorEnv]


@pytest.fixture
def make_env() -> Iterator[MakeEnv]:
    """Makes environments that are closed after the test."""
    made: list[ProcgenVectorEnv] = []

    def make(games: str = "coinrun", num_envs: int = _N, **arguments: object) -> ProcgenVectorEnv:
        options = {"distribution_mode": "easy", "rand_seed": 1} | arguments
        made.append(ProcgenVectorEnv(games, num_envs, **options))
        return made[-1]

    yield make
    for env in made:
        env.close()


def test_metadata_contains_the_autoreset_mode(make_env: MakeEnv) -> None:
    # vector/vector_env.py, VectorEnv: wrappers read the mode from "metadata[autoreset_mode]".
    # Ours is NEXT_STEP by default: normalising wrappers accept nothing else
    # (wrappers/vector/stateful_observation.py).
    assert make_env().metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    for mode in AutoresetMode:
        assert make_env(autoreset_mode=mode).metadata["autoreset_mode"] is mode
        assert make_env(autoreset_mode=mode.value).metadata["autoreset_mode"] is mode
    # Instances do not change the class attribute.
    assert ProcgenVectorEnv.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP


def test_batched_spaces_contain_a_batch(make_env: MakeEnv) -> None:
    # vector/vector_env.py, VectorEnv: observation_space and action_space are batched versions of
    # the single ones; of Discrete that is MultiDiscrete (vector/utils/space_utils.py, batch_space).
    env = make_env()
    observations, _ = env.reset()
    assert observations in env.observation_space
    assert observations[0] in env.single_observation_space
    assert env.single_action_space.n == 15
    assert env.action_space.nvec.tolist() == [15] * _N
    env.action_space.seed(3)
    for _ in range(5):
        actions = env.action_space.sample()
        assert actions in env.action_space
        env.step(actions)
    assert [15, 0, 0, 0] not in env.action_space
    assert env.single_observation_space.sample() in env.single_observation_space
    assert observations.astype(np.float32) not in env.observation_space


def test_random_stream_exists(make_env: MakeEnv) -> None:
    # vector/vector_env.py, VectorEnv.np_random and np_random_seed: made when first asked for.
    env = make_env()
    seed = env.np_random_seed
    expected = np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed)))
    assert env.np_random.integers(1 << 62) == expected.integers(1 << 62)
    env.np_random = np.random.default_rng(1)
    assert env.np_random_seed == -1


def test_frame_skip_repeats_actions_and_sums_rewards(make_env: MakeEnv) -> None:
    # Ours: repeats each action, sums the rewards and returns the last frame.
    skipping, plain = make_env("bigfish", frame_skip=3), make_env("bigfish")
    skipping.reset()
    plain.reset()
    for step in range(30):
        actions = np.full(_N, step % 9)
        observations, rewards, *_ = skipping.step(actions)
        steps = [plain.step(actions) for _ in range(3)]
        if any((step[2] | step[3]).any() for step in steps):
            break
        np.testing.assert_array_equal(observations, steps[-1][0])
        np.testing.assert_array_equal(rewards, sum(step[1] for step in steps))
    assert step > 3
    with pytest.raises(errors.InvalidArgumentError, match="frame_skip is 0"):
        make_env(frame_skip=0)


def test_next_levels_are_played_after_the_episode(make_env: MakeEnv) -> None:
    # Ours: no source in Gymnasium.
    env = make_env(autoreset_mode=AutoresetMode.SAME_STEP)
    env.reset()
    env.set_next_levels({0: 123})
    env.set_next_levels({1: 77, 2: 78})
    env.step(_NOTHING)
    _, _, _, _, infos = env.step(np.array([-1, -1, 4, 4]))
    assert infos["level_seed"][:2].tolist() == [123, 77]
    _, _, _, _, infos = env.step(_END_OF_FIRST)
    assert infos["level_seed"][0] != 123
    with pytest.raises(errors.InvalidArgumentError, match="environment is 4"):
        env.set_next_levels({4: 1})


def test_ended_episodes_are_reported(make_env: MakeEnv) -> None:
    # Ours: no source in Gymnasium.
    for mode in AutoresetMode:
        env = make_env(autoreset_mode=mode)
        env.reset()
        env.step(_END_OF_FIRST)
        is_over = mode is not AutoresetMode.SAME_STEP
        assert env.episodes_over.tolist() == [is_over, False, False, False]


def test_reset_returns_observations_and_infos(make_env: MakeEnv) -> None:
    # vector/vector_env.py, VectorEnv.reset: "-> (observations, infos)"; seed and options are
    # keyword-only.
    observations, infos = make_env().reset()
    assert observations.shape == (_N, 64, 64, 3)
    assert observations.dtype == np.uint8
    assert observations.flags.writeable
    assert infos["_level_seed"].all()
    with pytest.raises(TypeError):
        make_env().reset(0)


def test_step_returns_five_values_with_float64_rewards(make_env: MakeEnv) -> None:
    # vector/sync_vector_env.py, __init__: rewards are np.float64, terminations and truncations
    # np.bool_.
    env = make_env()
    env.reset()
    observations, rewards, terminations, truncations, infos = env.step(_NOTHING)
    assert observations.shape == (_N, 64, 64, 3)
    assert (rewards.dtype, rewards.shape) == (np.float64, (_N,))
    assert (terminations.dtype, terminations.shape) == (np.bool_, (_N,))
    assert (truncations.dtype, truncations.shape) == (np.bool_, (_N,))
    assert isinstance(infos, dict)


def test_an_int_seed_is_expanded_over_environments(make_env: MakeEnv) -> None:
    # vector/sync_vector_env.py, reset: "if isinstance(seed, int): seed = [seed + i ...]".
    env = make_env()
    one, infos = env.reset(seed=10)
    other, _ = env.reset(seed=[10, 11, 12, 13])
    np.testing.assert_array_equal(one, other)
    shifted, shifted_infos = env.reset(seed=11)
    assert shifted_infos["level_seed"][0] == infos["level_seed"][1]


def test_equal_seeds_give_equal_episodes(make_env: MakeEnv) -> None:
    # core.py, Env.reset: a seed makes what follows reproducible.
    env = make_env()
    runs = []
    for _ in range(2):
        env.reset(seed=3)
        rng = np.random.default_rng(0)
        steps = [env.step(rng.integers(0, 15, _N)) for _ in range(30)]
        runs.append(np.stack([step[0] for step in steps]))
    np.testing.assert_array_equal(*runs)


def test_seed_list_has_one_seed_per_environment(make_env: MakeEnv) -> None:
    # vector/sync_vector_env.py, reset: "assert len(seed) == self.num_envs"; entries may be None.
    env = make_env()
    with pytest.raises(errors.InvalidArgumentError, match="seed has 3 entries"):
        env.reset(seed=[1, 2, 3])
    env.reset(seed=[1, None, 2, None])


def test_reset_without_a_seed_starts_other_episodes(make_env: MakeEnv) -> None:
    # core.py, Env.reset: without a seed the random stream continues. The first reset returns the
    # levels that the pool was created with, as in Procgen 0.10.7.
    env = make_env()
    _, first = env.reset()
    _, second = env.reset()
    _, twin = make_env().reset()
    assert first["level_seed"].tolist() == twin["level_seed"].tolist()
    assert first["level_seed"].tolist() != second["level_seed"].tolist()


def test_reset_mask_selects_environments(make_env: MakeEnv) -> None:
    # vector/sync_vector_env.py, reset: environments outside of options["reset_mask"] keep their
    # observations, and infos cover only those inside.
    env = make_env(autoreset_mode=AutoresetMode.DISABLED)
    before, _ = env.reset()
    options = {"reset_mask": np.array([False, True, False, False])}
    after, infos = env.reset(options=options)
    assert infos["_level_seed"].tolist() == [False, True, False, False]
    np.testing.assert_array_equal(before[[0, 2, 3]], after[[0, 2, 3]])


@pytest.mark.parametrize(
    "mask",
    [np.zeros(_N, np.bool_), np.ones(_N + 1, np.bool_), np.ones(_N, np.int64), [True] * _N],
)
def test_malformed_reset_mask_is_rejected(make_env: MakeEnv, mask: object) -> None:
    # vector/sync_vector_env.py, reset: asserts an ndarray, its shape, its dtype, at least one True.
    with pytest.raises(errors.InvalidArgumentError, match="reset_mask"):
        make_env().reset(options={"reset_mask": mask})


def test_next_step_mode_starts_the_episode_one_step_later(make_env: MakeEnv) -> None:
    # vector/sync_vector_env.py, step, AutoresetMode.NEXT_STEP: after the end, one step with the
    # reset's observation, reward 0 and no flags, whose action is ignored.
    env = make_env()
    env.reset()
    last, _, terminations, truncations, infos = env.step(_END_OF_FIRST)
    assert (terminations | truncations).tolist() == [True, False, False, False]
    assert infos["level_seed"][0] == infos["prev_level_seed"][0]
    assert "final_obs" not in infos
    first, rewards, terminations, truncations, infos = env.step(_END_OF_FIRST)
    assert rewards[0] == 0
    assert not (terminations | truncations).any()
    assert (first[0] != last[0]).any()
    _, _, _, _, infos_after = env.step(_NOTHING)
    assert infos_after["level_seed"][0] == infos["level_seed"][0]


def test_same_step_mode_starts_the_episode_in_the_same_step(make_env: MakeEnv) -> None:
    # vector/sync_vector_env.py, step, AutoresetMode.SAME_STEP: observations are the next episode's;
    # the old one's last is in infos["final_obs"] (an array of objects, None elsewhere), its infos
    # in infos["final_info"] with masks of their own.
    env = make_env(autoreset_mode=AutoresetMode.SAME_STEP)
    _, before = env.reset()
    quiet = env.step(_NOTHING)
    assert "final_obs" not in quiet[4]
    first, _, terminations, _, infos = env.step(_END_OF_FIRST)
    assert terminations.tolist() == [True, False, False, False]
    assert infos["final_obs"].dtype == object
    assert infos["_final_obs"].tolist() == [True, False, False, False]
    assert infos["final_obs"][1:].tolist() == [None] * 3
    assert infos["final_obs"][0].shape == (64, 64, 3)
    assert (infos["final_obs"][0] != first[0]).any()
    final_info = infos["final_info"]
    assert infos["_final_info"].tolist() == [True, False, False, False]
    assert final_info["_level_seed"].tolist() == [True, False, False, False]
    assert final_info["level_seed"][0] == before["level_seed"][0]
    assert infos["level_seed"][0] != before["level_seed"][0]
    assert infos["level_seed"][1] == before["level_seed"][1]
    assert (infos["episode_return"].dtype, infos["episode_length"].dtype) == (np.float64, np.int64)
    assert infos["episode_length"].tolist() == [2, 0, 0, 0]
    numbers = {name: final_info[name].dtype for name in final_info if name[0] != "_"}
    assert numbers == {
        "level_seed": np.int64,
        "prev_level_seed": np.int64,
        "prev_level_complete": np.bool_,
        "episode_return": np.float64,
        "episode_length": np.int64,
    }
    for name in ("episode_return", "episode_length"):
        assert final_info[name].tolist() == infos[name].tolist()
        assert final_info[f"_{name}"].tolist() == [True, False, False, False]
    assert not final_info["level_seed"][1:].any()


def test_all_modes_play_the_same_episodes(make_env: MakeEnv) -> None:
    # Ours: the modes differ only in the step at which the next episode starts.
    same = make_env(autoreset_mode=AutoresetMode.SAME_STEP)
    next_ = make_env(autoreset_mode=AutoresetMode.NEXT_STEP)
    disabled = make_env(autoreset_mode=AutoresetMode.DISABLED)
    for env in (same, next_, disabled):
        env.reset()
    end = np.full(_N, -1)
    at_once, _, _, _, infos = same.step(end)
    last, *_ = next_.step(end)
    first, *_ = next_.step(_NOTHING)
    last_too, *_ = disabled.step(end)
    first_too, _ = disabled.reset()
    np.testing.assert_array_equal(np.stack(list(infos["final_obs"])), last)
    np.testing.assert_array_equal(last, last_too)
    np.testing.assert_array_equal(at_once, first)
    np.testing.assert_array_equal(at_once, first_too)


def test_disabled_mode_requires_a_reset_of_ended_environments(make_env: MakeEnv) -> None:
    # vector/sync_vector_env.py, step, AutoresetMode.DISABLED: asserts that no environment is over.
    env = make_env(autoreset_mode=AutoresetMode.DISABLED)
    env.reset()
    _, _, terminations, truncations, _ = env.step(_END_OF_FIRST)
    with pytest.raises(errors.FailedPreconditionError, match="environments \\[0\\] are over"):
        env.step(_NOTHING)
    env.reset(options={"reset_mask": terminations | truncations})
    env.step(_NOTHING)


def test_step_async_and_step_wait_equal_a_step(make_env: MakeEnv) -> None:
    # vector/async_vector_env.py, step_async and step_wait.
    env, twin = make_env(), make_env()
    env.reset(seed=5)
    twin.reset(seed=5)
    for action in range(9):
        twin.step_async(np.full(_N, action))
        for whole, halves in zip(env.step(np.full(_N, action)), twin.step_wait(), strict=True):
            if isinstance(whole, np.ndarray):
                np.testing.assert_array_equal(whole, halves)


def test_step_async_and_step_wait_must_alternate(make_env: MakeEnv) -> None:
    # vector/async_vector_env.py: a call while another is pending is an error, and so is waiting for
    # a step that was not started.
    env = make_env()
    env.reset()
    with pytest.raises(errors.FailedPreconditionError, match="step_async was not called"):
        env.step_wait()
    env.step_async(_NOTHING)
    with pytest.raises(errors.FailedPreconditionError, match="call step_wait first"):
        env.step_async(_NOTHING)
    with pytest.raises(errors.FailedPreconditionError, match="unanswered"):
        env.reset()
    env.step_wait()
    env.step(_NOTHING)


def test_infos_have_masks(make_env: MakeEnv) -> None:
    # vector/vector_env.py, VectorEnv._add_info: for each key an array and a mask "_key".
    env = make_env(autoreset_mode=AutoresetMode.SAME_STEP)
    env.reset()
    _, _, _, _, infos = env.step(_END_OF_FIRST)
    keys = {key for key in infos if not key.startswith("_")}
    assert keys == {
        "level_seed",
        "prev_level_seed",
        "prev_level_complete",
        "episode_return",
        "episode_length",
        "final_obs",
        "final_info",
    }
    for key in keys:
        assert infos[f"_{key}"].dtype == np.bool_
        assert infos[f"_{key}"].shape == (_N,)
    assert infos["episode_length"].tolist() == [1, 0, 0, 0]


def test_arrays_that_are_kept_never_change(make_env: MakeEnv) -> None:
    # vector/sync_vector_env.py: "copy: If True, then the reset and step methods return a copy".
    for mode in AutoresetMode:
        env = make_env(autoreset_mode=mode)
        env.reset()
        kept = [env.step(_NOTHING)[:4] for _ in range(8)]
        before = [[array.copy() for array in arrays] for arrays in kept]
        assert kept[0][0].flags.writeable
        env.step(_NOTHING)
        for arrays, expected in zip(kept, before, strict=True):
            for array, its_expected in zip(arrays, expected, strict=True):
                np.testing.assert_array_equal(array, its_expected)


def test_render_returns_a_frame_for_each_environment(client: Client, make_env: MakeEnv) -> None:
    # vector/vector_env.py, VectorEnv.render: "Returns the rendered frames" as a tuple; None without
    # a render mode.
    assert make_env().render() is None
    with pytest.raises(errors.InvalidArgumentError, match="render_mode is 'human'"):
        make_env(render_mode="human")
    env = make_env(render_mode="rgb_array", render_size_px=128)
    env.reset()
    frames = env.render()
    assert isinstance(frames, tuple)
    assert [frame.shape for frame in frames] == [(128, 128, 3)] * _N


def test_close_is_idempotent(client: Client) -> None:
    # vector/vector_env.py, VectorEnv.close: "if self.closed: return".
    before = len(client.list_pools())
    env = ProcgenVectorEnv("maze", 2, server=client)
    assert len(client.list_pools()) == before + 1
    env.close()
    env.close()
    assert env.closed
    assert len(client.list_pools()) == before


def test_garbage_collected_environment_deletes_its_pool(client: Client) -> None:
    # vector/vector_env.py, VectorEnv.__del__: closes.
    before = len(client.list_pools())
    env = ProcgenVectorEnv("maze", 2, server=client)
    env.reset()
    del env
    assert len(client.list_pools()) == before


def test_given_client_stays_open(client: Client) -> None:
    with ProcgenVectorEnv("maze", 1, server=client) as env:
        env.reset()
    assert env.closed
    assert not client.closed


def test_failed_constructor_leaves_no_pool(client: Client) -> None:
    before = len(client.list_pools())
    with pytest.raises(errors.InvalidArgumentError, match="'Never'.*'NextStep'"):
        ProcgenVectorEnv("maze", 1, server=client, autoreset_mode="Never")
    with pytest.raises(errors.NotFoundError, match="pong"):
        ProcgenVectorEnv("pong", 1, server=client)
    assert len(client.list_pools()) == before
