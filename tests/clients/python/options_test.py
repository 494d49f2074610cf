"""Options of environments: unknown names, wrong types, values without an effect."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from procgen_client import (
    Client,
    Pool,
    ProcgenEnv,
    ProcgenGym3Env,
    ProcgenGymEnv,
    ProcgenVectorEnv,
    ServerProcess,
    errors,
)

_Make = Callable[..., Any]


def _make_vector(**options: object) -> ProcgenVectorEnv:
    return ProcgenVectorEnv("maze", **{"num_envs": 2, **options})


def _make_single(**options: object) -> ProcgenGymEnv:
    return ProcgenGymEnv("maze", **options)


def _make_gym3(**options: object) -> ProcgenGym3Env:
    return ProcgenGym3Env(**{"num": 2, "env_name": "maze", **options})


def _make_baselines(**options: object) -> ProcgenEnv:
    return ProcgenEnv(**{"num_envs": 2, "env_name": "maze", **options})


def _make_pool(**options: object) -> Pool:
    return Pool("maze", 2, **options)


_MAKERS = {
    "ProcgenVectorEnv": _make_vector,
    "ProcgenGymEnv": _make_single,
    "ProcgenGym3Env": _make_gym3,
    "ProcgenEnv": _make_baselines,
    "Pool": _make_pool,
}
_ALL = pytest.mark.parametrize(("owner", "make"), _MAKERS.items(), ids=list(_MAKERS))


@_ALL
def test_unknown_option_is_rejected_with_the_nearest_name(
    owner: str, make: _Make
) -> None:
    message = rf"{owner} has no option 'num_level' \(did you mean 'num_levels'\?\)"
    with pytest.raises(TypeError, match=message) as caught:
        make(num_level=200)
    assert isinstance(caught.value, errors.InvalidArgumentError)
    assert "distribution_mode, " in str(caught.value), "all names are listed"
    with pytest.raises(TypeError, match=rf"{owner} has no option 'zzz'; its options are"):
        make(zzz=1)


def test_option_that_a_single_environment_has_not_is_rejected() -> None:
    for name in ("num_envs", "autoreset_mode"):
        with pytest.raises(TypeError, match=f"ProcgenGymEnv has no option '{name}'"):
            _make_single(**{name: 2})


def test_options_are_listed_by_the_names_of_their_class() -> None:
    for make, has, has_not in (
        (_make_vector, "num_envs", "env_count"),
        (_make_baselines, "num_envs", "num"),
        (_make_gym3, "num", "num_envs"),
        (_make_pool, "env_count", "num_envs"),
    ):
        with pytest.raises(TypeError) as caught:
            make(zzz=1)
        names = str(caught.value).partition("its options are ")[2].split(", ")
        assert has in names and has_not not in names


@_ALL
@pytest.mark.parametrize(
    ("option", "value", "allowed"),
    [
        ("num_levels", 2**31, r"it is in \[0, 2147483647\]"),
        ("num_levels", 4.0, r"it is an integer in \[0, 2147483647\]"),
        ("start_level", "3", r"it is an integer in \[0, "),
        ("rand_seed", "0", r"it is an integer in \[-2147483648, 4294967295\]"),
        ("rand_seed", 2**40, r"it is in \[-2147483648, 4294967295\]"),
        ("debug_mode", None, r"it is an integer in "),
        ("distribution_mode", 1, "it is one of easy, hard, "),
    ],
)
def test_wrong_value_names_its_option(
    owner: str, make: _Make, option: str, value: object, allowed: str
) -> None:
    shown = str(value) if isinstance(value, int) and option != "distribution_mode" else repr(value)
    with pytest.raises(errors.InvalidArgumentError, match=f"{option} is {shown}; {allowed}"):
        make(**{option: value})


@pytest.mark.parametrize(
    ("make", "option", "value", "allowed"),
    [
        (_make_vector, "num_envs", 4.0, "it is an integer in"),
        (_make_vector, "num_envs", 0, r"it is in \[1, "),
        (_make_vector, "screen_size", (84, 84), r"it is an integer in \[16, 512\]"),
        (_make_vector, "frame_stack", "4", r"it is an integer in \[1, 16\]"),
        (_make_vector, "frame_skip", 1.5, r"it is an integer in \[1, 1000\]"),
        (_make_vector, "use_backgrounds", "no", "it is True or False"),
        (_make_baselines, "num_envs", 4.0, "it is an integer in"),
        (_make_gym3, "num", -1, r"it is in \[1, "),
        (_make_gym3, "env_name", 5, "it is the name of a game"),
        (_make_pool, "first_env", 2**31, r"it is in \[0, 2147483647\]"),
        (_make_pool, "autoreset_mode", "never", "it is one of same_step, next_step, disabled"),
        (_make_pool, "num_threads", 1025, r"it is in \[0, 1024\]"),
        (_make_pool, "encoding", "gzip", "it is one of raw, delta_zstd"),
    ],
)
def test_value_of_a_wrong_type_names_its_option(
    make: _Make, option: str, value: object, allowed: str
) -> None:
    with pytest.raises(errors.InvalidArgumentError) as caught:
        make(**{option: value})
    assert caught.match(f"{option} is .*; {allowed}")


@pytest.mark.parametrize("games", [64, [], ["maze", 3], None])
def test_games_are_names(games: object) -> None:
    with pytest.raises(errors.InvalidArgumentError, match="it is the name of a game, or a list"):
        Pool(games, 2)


def test_numpy_numbers_are_accepted() -> None:
    numbers = {"num_envs": np.int32(2), "num_levels": np.int64(3), "rand_seed": np.uint32(2**31)}
    with _make_vector(use_backgrounds=np.bool_(False), **numbers) as env:
        assert env.num_envs == 2
        assert env.pool.options["rand_seed"] == 2**31
        assert env.pool.step([-1, -1]).level_seeds.max() < 3


@_ALL
def test_start_level_without_num_levels_is_warned_of(
    owner: str, make: _Make
) -> None:
    message = "start_level is 42, but num_levels is 0 .* num_levels=1 plays just this level"
    with pytest.warns(UserWarning, match=message) as caught:
        make(start_level=42).close()
    assert [each.filename for each in caught] == [__file__], "once, at the line of the caller"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        make(start_level=42, num_levels=1).close()
        make(start_level=0, num_levels=0).close()


def test_options_of_the_other_place_are_ignored() -> None:
    server_only = {"encoding": "delta_zstd", "pool_id": "mine", "name": "n", "labels": {"a": "b"}}
    with Pool("maze", 2, **server_only, rand_seed=1) as pool:
        with Pool("maze", 2, rand_seed=1) as plain:
            assert pool.name == ""
            np.testing.assert_array_equal(pool.observe().observations, plain.observe().observations)


def test_none_is_the_default_of_optional_values() -> None:
    with Pool("maze", 2, rand_seed=None, num_threads=None, level_sampler=None) as pool:
        assert isinstance(pool.options["rand_seed"], int)


def test_variable_puts_pools_without_a_server_on_one(
    server: ServerProcess, monkeypatch: pytest.MonkeyPatch
) -> None:
    for given, is_there in ((server.address, True), ("", False)):
        monkeypatch.setenv("PROCGEN_SERVER", given)
        with Pool("maze", 2) as pool:
            assert (pool.client is not None) == is_there
            assert pool.step([4, 4]).env_count == 2
    monkeypatch.setenv("PROCGEN_SERVER", server.address)
    with pytest.raises(errors.InvalidArgumentError, match="chooses its art by its flag"):
        Pool("maze", 2, art="procgen")


def test_servers_are_addresses_clients_and_processes(server: ServerProcess, client: Client) -> None:
    places = (server.address, client, server)
    pools = [Pool("maze", 2, server=given, rand_seed=1) for given in places]
    assert pools[1].client is client
    observations = [pool.observe().observations for pool in pools]
    for pool, other in zip(pools, observations, strict=True):
        np.testing.assert_array_equal(other, observations[0])
        assert pool.name in [message.name for message in client.list_pools()]
        connection = pool.client
        pool.close()
        assert pool.name not in [message.name for message in client.list_pools()]
        assert connection.closed == (connection is not client)
