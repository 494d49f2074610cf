"""Compatibility with upstream's interfaces, with the source of each rule.

Upstream is the package `procgen` 0.10.7. Sources are the documented behaviour of gym3 and upstream.
The recordings in tests/conformance cover levels, rewards and ends.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from procgen_client import (
    ENV_NAMES,
    Client,
    ProcgenEnv,
    ProcgenGym3Env,
    ProcgenVectorEnv,
    errors,
)

_N = 4
_OPTIONS = {"distribution_mode": "easy", "rand_seed": 7}
_END = np.array([-1, 4, 4, 4])


@pytest.fixture
def env() -> Iterator[ProcgenGym3Env]:
    """Four environments."""
    made = ProcgenGym3Env(_N, "coinrun", **_OPTIONS)
    yield made
    made.close()


@pytest.fixture
def venv() -> Iterator[ProcgenEnv]:
    """Four environments."""
    made = ProcgenEnv(_N, "coinrun", **_OPTIONS)
    yield made
    made.close()


def test_arguments_are_those_of_upstream() -> None:
    # Upstream: ProcgenGym3Env(num, env_name, center_agent=True, ...), in this order.
    parameters = dict(inspect.signature(ProcgenGym3Env).parameters)
    assert parameters.pop("unknown").kind is inspect.Parameter.VAR_KEYWORD
    assert {name: each.default for name, each in parameters.items()} == {
        "num": inspect.Parameter.empty,
        "env_name": inspect.Parameter.empty,
        "center_agent": True,
        "use_backgrounds": True,
        "use_monochrome_assets": False,
        "restrict_themes": False,
        "use_generated_assets": False,
        "paint_vel_info": False,
        "distribution_mode": "hard",
        "num_levels": 0,
        "start_level": 0,
        "use_sequential_levels": False,
        "debug_mode": 0,
        "rand_seed": None,
        "num_threads": 4,
        "render_mode": None,
        "debug": False,
        "resource_root": None,
        "art": None,
        "server": None,
    }


def test_observe_is_valid_before_any_act_and_idempotent(env: ProcgenGym3Env) -> None:
    # gym3: observe() -> (reward, ob, first), reward first; first is all True at the start.
    for _ in range(2):
        reward, ob, first = env.observe()
        assert (reward.dtype, reward.tolist()) == (np.float32, [0] * _N)
        assert list(ob) == ["rgb"]
        assert (ob["rgb"].dtype, ob["rgb"].shape) == (np.uint8, (_N, 64, 64, 3))
        assert (first.dtype, first.tolist()) == (np.bool_, [True] * _N)
    env.act(_END)
    one, other = env.observe(), env.observe()
    np.testing.assert_array_equal(one[1]["rgb"], other[1]["rgb"])
    assert one[2].tolist() == other[2].tolist() == [True, False, False, False]


def test_observed_arrays_are_copies(env: ProcgenGym3Env) -> None:
    # gym3: arrays may be kept and written.
    kept = []
    for _ in range(12):
        _, ob, _ = env.observe()
        kept.append((ob["rgb"], ob["rgb"].copy()))
        env.act(np.full(_N, 7))
    for array, content in kept:
        np.testing.assert_array_equal(array, content)
        array[:] = 0


def test_acting_twice_steps_twice(env: ProcgenGym3Env, client: Client) -> None:
    # gym3: act may be called without observing between.
    with client.create_pool("coinrun", _N, **_OPTIONS) as pool:
        for _ in range(6):
            batch = pool.step([7] * _N)
        for _ in range(6):
            env.act(np.full(_N, 7))
        _, ob, _ = env.observe()
        np.testing.assert_array_equal(batch.observations, ob["rgb"])


def test_infos_contain_levels(env: ProcgenGym3Env) -> None:
    # Upstream: prev_level_seed, prev_level_complete, level_seed; on the step into a new
    # episode prev_* belong to the old one.
    before = env.get_info()
    assert [set(info) for info in before] == [
        {"prev_level_seed", "prev_level_complete", "level_seed"}
    ] * _N
    env.act(_END)
    after = env.get_info()
    assert after[0]["prev_level_seed"] == before[0]["level_seed"] != after[0]["level_seed"]
    assert after[1]["level_seed"] == before[1]["level_seed"]


def test_render_mode_adds_frames_to_infos() -> None:
    # Upstream: info["rgb"], uint8 [512, 512, 3], with render_mode="rgb_array".
    env = ProcgenGym3Env(2, "maze", render_mode="rgb_array")
    assert [info["rgb"].shape for info in env.get_info()] == [(512, 512, 3)] * 2
    env.close()
    with pytest.raises(errors.InvalidArgumentError, match="'window'"):
        ProcgenGym3Env(2, "maze", render_mode="window")


def test_spaces_describe_observations_and_actions(env: ProcgenGym3Env) -> None:
    # gym3: ob_space is a DictType, ac_space a TensorType of Discrete(15); num.
    assert env.num == _N
    assert env.ob_space["rgb"].shape == (64, 64, 3)
    assert env.ob_space["rgb"].eltype.n == 256
    assert env.ac_space.eltype.n == 15
    assert env.ac_space.shape == ()


def test_callmethod_saves_and_restores_states(env: ProcgenGym3Env) -> None:
    # gym3: callmethod(name, *lists) returns a list of each environment's result.
    for _ in range(5):
        env.act(np.full(_N, 7))
    states = env.callmethod("get_state")
    env.act(np.full(_N, 5))
    expected = env.observe()
    assert env.callmethod("set_state", states) == [None] * _N
    env.act(np.full(_N, 5))
    after = env.observe()
    np.testing.assert_array_equal(expected[0], after[0])
    np.testing.assert_array_equal(expected[1]["rgb"], after[1]["rgb"])
    np.testing.assert_array_equal(expected[2], after[2])
    with pytest.raises(errors.InvalidArgumentError, match="get_state, set_state"):
        env.callmethod("fly")
    with pytest.raises(errors.InvalidArgumentError, match="states has 1 entries"):
        env.callmethod("set_state", states[:1])


def test_actions_are_key_combinations_of_upstream(env: ProcgenGym3Env) -> None:
    # Upstream: 15 combinations, LEFT+DOWN first, none is 4.
    assert env.get_combos() == [
        *(("LEFT", "DOWN"), ("LEFT",), ("LEFT", "UP"), ("DOWN",), (), ("UP",)),
        *(("RIGHT", "DOWN"), ("RIGHT",), ("RIGHT", "UP")),
        *(("D",), ("A",), ("W",), ("S",), ("Q",), ("E",)),
    ]


def test_keys_map_to_the_action_with_most_matching_keys(env: ProcgenGym3Env) -> None:
    # Upstream, keys_to_act: for each list of keys an array of one action; it has `combos`, too.
    keys = [[], ["LEFT"], ["UP", "LEFT"], ["A", "S"], ["RIGHT", "x", "DOWN"]]
    actions = env.keys_to_act(keys)
    assert [action.tolist() for action in actions] == [[4], [1], [2], [10], [6]]
    assert env.combos == env.get_combos()


@pytest.mark.parametrize(
    "actions",
    [
        np.array([0.0, 7.9, 3.2, -0.5], np.float64),
        np.array([0, 7, 3, 0], np.float32),
        np.array([0, 7, 3, 0], np.int64),
        np.array([0, 7, 3, 0], np.uint64),
        np.array([0, 7, 2**32 + 3, 0], np.int64),
        np.array([0, 7, 3, 0], object),
        [0, 7.9, 3, False],
    ],
)
def test_actions_are_cast_as_upstream_casts_them(
    env: ProcgenGym3Env, venv: ProcgenEnv, client: Client, actions: object
) -> None:
    # Upstream, act: ac.astype(np.int32).
    with client.create_pool("coinrun", _N, **_OPTIONS) as pool:
        expected = pool.step([0, 7, 3, 0]).observations
    env.act(actions)
    np.testing.assert_array_equal(env.observe()[1]["rgb"], expected)
    np.testing.assert_array_equal(venv.step(actions)[0]["rgb"], expected)


@pytest.mark.parametrize("bad", [np.nan, np.inf, 15, 15.0, -2.0, 1e10, "left", None])
def test_invalid_actions_are_rejected(env: ProcgenGym3Env, bad: object) -> None:
    with pytest.raises(errors.InvalidArgumentError, match="ac has type|environment 3 is not in"):
        env.act([4, 4, 4, bad])
    env.act([4, 4, 4, 4])
    env.observe()


def test_several_games_are_assigned_round_robin(client: Client) -> None:
    # Upstream, env_name: names separated by commas; environment n plays name n mod their number,
    # and the number of environments is a multiple of theirs.
    env = ProcgenGym3Env(4, "coinrun,maze", **_OPTIONS)
    assert env.pool.games == ("coinrun", "maze")
    mixed = env.observe()[1]["rgb"]
    env.close()
    with client.create_pool("maze", 4, **_OPTIONS) as pool:
        np.testing.assert_array_equal(mixed[1::2], pool.observe().observations[1::2])
    with pytest.raises(AssertionError, match="num is 3; it is a multiple of 2"):
        ProcgenGym3Env(3, "coinrun,maze")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"distribution_mode": "simple"}, "'simple'; it is one of easy, hard"),
        ({"distribution_mode": "extreme"}, "extreme"),
        ({"env_name": "bigfish", "distribution_mode": "exploration"}, "exploration"),
        ({"distribution_mode": "exploration", "num_levels": 5}, "num_levels"),
        ({"debug": True}, "debug is True; it is False"),
    ],
)
def test_options_that_upstream_asserts_are_assertion_errors(arguments: dict, message: str) -> None:
    # Upstream: `assert` in the constructor. Here they are InvalidArgumentErrors as well.
    with pytest.raises(AssertionError, match=message) as caught:
        ProcgenGym3Env(**({"num": 1, "env_name": "coinrun"} | arguments))
    assert isinstance(caught.value, errors.InvalidArgumentError)


def test_options_are_cast_to_bool_as_upstream_casts_them() -> None:
    # Upstream: bool(center_agent) and the like.
    arguments = {"use_backgrounds": 0, "center_agent": np.bool_(False), "restrict_themes": 1}
    env = ProcgenGym3Env(1, "maze", **arguments)
    assert env.options["use_backgrounds"] is False
    assert env.options["restrict_themes"] is True
    env.close()


def test_env_names_lists_the_games(client: Client) -> None:
    # Upstream, procgen.env.ENV_NAMES.
    assert ENV_NAMES == sorted(game.name for game in client.catalog().games)


def test_resource_root_is_rejected_with_a_running_server(
    client: Client, tmp_path: Path
) -> None:
    # Upstream, resource_root: the art folder. A running server already has one.
    with pytest.raises(errors.InvalidArgumentError, match=f"{tmp_path}.*by its flag --art_dir"):
        ProcgenEnv(1, "maze", resource_root=tmp_path, server=client)


def test_rejected_actions_change_nothing(env: ProcgenGym3Env) -> None:
    with pytest.raises(errors.InvalidArgumentError, match="ac has shape \\[3\\]; it is \\[4\\]"):
        env.act(np.zeros(3, np.int32))
    with pytest.raises(errors.InvalidArgumentError, match="action 15 of environment 0 is not in"):
        env.act(np.full(_N, 15))
    env.act(np.full(_N, 14))
    env.observe()


def test_baselines_reset_and_step(venv: ProcgenEnv, env: ProcgenGym3Env) -> None:
    # baselines: reset() -> ob; step(ac) -> (ob, rew, done, list of infos).
    ob = venv.reset()
    np.testing.assert_array_equal(ob["rgb"], env.observe()[1]["rgb"])
    for step in range(40):
        actions = np.full(_N, step % 15)
        actions[0] = -1 if step % 9 == 8 else actions[0]
        ob, rewards, done, infos = venv.step(actions)
        env.act(actions)
        reward, expected, first = env.observe()
        np.testing.assert_array_equal(ob["rgb"], expected["rgb"])
        np.testing.assert_array_equal(rewards, reward)
        np.testing.assert_array_equal(done, first)
        for row, terminal in env.terminal_infos().items():
            assert done[row]
            assert terminal.items() >= {"TimeLimit.truncated": False}.items()
            assert infos[row].keys() - terminal.keys() == env.get_info()[row].keys()
            infos[row] = {name: infos[row][name] for name in infos[row].keys() - terminal.keys()}
        assert infos == env.get_info()


def test_baselines_reset_is_ignored_within_an_episode(venv: ProcgenEnv) -> None:
    # Upstream: only the game ends an episode; a reset within one is ignored.
    venv.reset()
    ob, *_ = venv.step(np.full(_N, 7))
    with pytest.warns(UserWarning, match="within an episode"):
        again = venv.reset()
    np.testing.assert_array_equal(ob["rgb"], again["rgb"])


def test_baselines_spaces(venv: ProcgenEnv) -> None:
    # baselines: num_envs, observation_space, action_space.
    assert venv.num_envs == _N
    assert venv.observation_space["rgb"].shape == (64, 64, 3)
    assert venv.action_space.n == 15
    assert venv.action_space.sample() in venv.action_space


def test_render_returns_environment_0(venv: ProcgenEnv) -> None:
    # Upstream, render: mode "human", the default, returns None; "rgb_array" returns info["rgb"] of
    # environment 0 if the infos have it, else its observation. metadata has the modes and the frame
    # rate for video recorders, with the keys of old and new Gym.
    observation = venv.reset()["rgb"][0]
    assert venv.render() is None
    assert venv.render("human") is None
    np.testing.assert_array_equal(venv.render(mode="rgb_array"), observation)
    with pytest.raises(errors.InvalidArgumentError, match="'ansi'; it is 'human' or 'rgb_array'"):
        venv.render("ansi")
    assert venv.metadata["render.modes"] == venv.metadata["render_modes"] == ["human", "rgb_array"]
    assert venv.metadata["video.frames_per_second"] == venv.metadata["render_fps"] == 15
    assert venv.render_mode is None
    many = ProcgenEnv(64, "coinrun", render_mode="rgb_array", **_OPTIONS)
    _, _, _, infos = many.step(np.full(64, 7))
    np.testing.assert_array_equal(many.render("rgb_array"), infos[0]["rgb"])
    assert many.render("rgb_array").shape == (512, 512, 3)
    assert many.render_mode == "rgb_array"
    many.close()


def test_levels_equal_those_of_a_vector_environment(venv: ProcgenEnv) -> None:
    with ProcgenVectorEnv("coinrun", _N, **_OPTIONS) as vector:
        _, infos = vector.reset()
        venv.reset()
        assert [info["level_seed"] for info in venv.env.get_info()] == infos["level_seed"].tolist()


def test_closing_deletes_the_pool(client: Client) -> None:
    before = len(client.list_pools())
    for cls in (ProcgenGym3Env, ProcgenEnv):
        env = cls(1, "maze", server=client)
        assert len(client.list_pools()) == before + 1
        env.close()
        env.close()
        with pytest.raises(errors.NotFoundError):
            cls(1, "pong", server=client)
    assert len(client.list_pools()) == before
