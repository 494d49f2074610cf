"""Options of environments: unknown names, wrong types, values without an effect."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from procgen_client import (
    Client,
    ProcgenEnv,
    ProcgenGym3Env,
    ProcgenGymEnv,
    ProcgenVectorEnv,
    errors,
)

_Make = Callable[..., Any]


def _make_vector(client: Client, **options: object) -> ProcgenVectorEnv:
    return ProcgenVectorEnv("maze", **{"num_envs": 2, "server": client, **options})


def _make_single(client: Client, **options: object) -> ProcgenGymEnv:
    return ProcgenGymEnv("maze", server=client, **options)


def _make_gym3(client: Client, **options: object) -> ProcgenGym3Env:
    return ProcgenGym3Env(**{"num": 2, "env_name": "maze", "server": client, **options})


def _make_baselines(client: Client, **options: object) -> ProcgenEnv:
    return ProcgenEnv(**{"num_envs": 2, "env_name": "maze", "server": client, **options})


def _make_pool(client: Client, **options: object) -> Any:  # noqa: ANN401
    return client.create_pool("maze", 2, **options)


_MAKERS = {
    "ProcgenVectorEnv": _make_vector,
    "ProcgenGymEnv": _make_single,
    "ProcgenGym3Env": _make_gym3,
    "ProcgenEnv": _make_baselines,
    "Client.create_pool": _make_pool,
}
_ALL = pytest.mark.parametrize(("owner", "make"), _MAKERS.items(), ids=list(_MAKERS))


@_ALL
def test_unknown_option_is_rejected_with_the_nearest_name(
    client: Client, owner: str, make: _Make
) -> None:
    message = rf"{owner} has no option 'num_level' \(did you mean 'num_levels'\?\)"
    with pytest.raises(TypeError, match=message) as caught:
        make(client, num_level=200)
    assert isinstance(caught.value, errors.InvalidArgumentError)
    assert "distribution_mode, " in str(caught.value), "all names are listed"
    with pytest.raises(TypeError, match=rf"{owner} has no option 'zzz'; its options are"):
        make(client, zzz=1)


def test_option_that_a_single_environment_has_not_is_rejected(client: Client) -> None:
    for name in ("num_envs", "autoreset_mode"):
        with pytest.raises(TypeError, match=f"ProcgenGymEnv has no option '{name}'"):
            _make_single(client, **{name: 2})


def test_options_are_listed_by_the_names_of_their_class(client: Client) -> None:
    for make, has, has_not in (
        (_make_vector, "num_envs", "env_count"),
        (_make_baselines, "num_envs", "num"),
        (_make_gym3, "num", "num_envs"),
        (_make_pool, "env_count", "num_envs"),
    ):
        with pytest.raises(TypeError) as caught:
            make(client, zzz=1)
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
    client: Client, owner: str, make: _Make, option: str, value: object, allowed: str
) -> None:
    shown = str(value) if isinstance(value, int) and option != "distribution_mode" else repr(value)
    with pytest.raises(errors.InvalidArgumentError, match=f"{option} is {shown}; {allowed}"):
        make(client, **{option: value})


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
    ],
)
def test_value_of_a_wrong_type_names_its_option(
    client: Client, make: _Make, option: str, value: object, allowed: str
) -> None:
    with pytest.raises(errors.InvalidArgumentError) as caught:
        make(client, **{option: value})
    assert caught.match(f"{option} is .*; {allowed}")


@pytest.mark.parametrize("games", [64, [], ["maze", 3], None])
def test_games_are_names(client: Client, games: object) -> None:
    with pytest.raises(errors.InvalidArgumentError, match="it is the name of a game, or a list"):
        client.create_pool(games, 2)


def test_numpy_numbers_are_accepted(client: Client) -> None:
    numbers = {"num_envs": np.int32(2), "num_levels": np.int64(3), "rand_seed": np.uint32(2**31)}
    with _make_vector(client, use_backgrounds=np.bool_(False), **numbers) as env:
        assert env.num_envs == 2
        assert env.pool.spec.options.num_levels == 3
        assert not env.pool.spec.options.use_backgrounds


@_ALL
def test_start_level_without_num_levels_is_warned_of(
    client: Client, owner: str, make: _Make
) -> None:
    message = "start_level is 42, but num_levels is 0 .* num_levels=1 plays just this level"
    with pytest.warns(UserWarning, match=message) as caught:
        make(client, start_level=42).close()
    assert [each.filename for each in caught] == [__file__], "once, at the line of the caller"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        make(client, start_level=42, num_levels=1).close()
        make(client, start_level=0, num_levels=0).close()
