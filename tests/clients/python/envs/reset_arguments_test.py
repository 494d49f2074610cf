"""The arguments of reset: levels by two names, seeds, and what is rejected."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from procgen_client import ProcgenGymEnv, ProcgenVectorEnv, errors

_N = 3


@pytest.fixture
def vector() -> Iterator[ProcgenVectorEnv]:
    """Three environments."""
    with ProcgenVectorEnv("maze", _N, distribution_mode="easy") as made:
        yield made


@pytest.fixture
def single() -> Iterator[ProcgenGymEnv]:
    """One environment."""
    with ProcgenGymEnv("maze", distribution_mode="easy") as made:
        yield made


@pytest.mark.parametrize("name", ["level_seed", "level_seeds"])
def test_levels_have_two_names(
    vector: ProcgenVectorEnv, single: ProcgenGymEnv, name: str
) -> None:
    for given, levels in (
        ([5, 6, 7], [5, 6, 7]),
        (np.array([8, 9, 2**31 - 1]), [8, 9, 2**31 - 1]),
        (4, [4] * _N),
        (np.int64(-3), [-3] * _N),
    ):
        _, infos = vector.reset(options={name: given})
        assert infos["level_seed"].tolist() == levels
    for given in (5, [5], np.array([5])):
        assert single.reset(options={name: given})[1]["level_seed"] == 5


def test_levels_are_those_of_the_reset_environments(vector: ProcgenVectorEnv) -> None:
    _, before = vector.reset()
    mask = np.array([False, True, False])
    _, infos = vector.reset(options={"level_seed": 77, "reset_mask": mask})
    assert infos["level_seed"].tolist() == [0, 77, 0]
    assert infos["_level_seed"].tolist() == mask.tolist()
    infos = vector.step([4] * _N)[-1]
    assert infos["level_seed"][[0, 2]].tolist() == before["level_seed"][[0, 2]].tolist()


@pytest.mark.parametrize("key", ["level", "level_sed", "levelSeed", "seed"])
def test_unknown_option_is_rejected(
    vector: ProcgenVectorEnv, single: ProcgenGymEnv, key: str
) -> None:
    for env, allowed in (
        (vector, "level_seed, level_seeds, reset_mask"),
        (single, "level_seed, level_seeds"),
    ):
        name = type(env).__name__
        expected = f"{name}.reset has no option '{key}'.*; its options are {allowed}$"
        with pytest.raises(errors.InvalidArgumentError, match=expected):
            env.reset(options={key: 5})


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"level_seed": 1, "level_seeds": [1, 2, 3]}, "are both given; give one"),
        ({"level_seeds": [1, 2]}, "level_seeds has 2 entries; there are 3 environments"),
        ({"level_seeds": [1, None, 3]}, r"level_seeds\[1\] is None; it is an integer in"),
        ({"level_seeds": [1, 2, 2**31]}, r"level_seeds\[2\] is 2147483648; it is in"),
        ({"level_seed": "5"}, r"level_seed is '5'; it is an integer in"),
        ({"level_seed": 1.5}, r"level_seed is 1.5; it is an integer in"),
    ],
)
def test_malformed_levels_are_rejected(
    vector: ProcgenVectorEnv, options: dict[str, object], message: str
) -> None:
    with pytest.raises(errors.InvalidArgumentError, match=message):
        vector.reset(options=options)


@pytest.mark.parametrize(
    ("seed", "message"),
    [
        (-1, r"seed is -1; it is in \[0, 4294967293\]"),
        (2**40, r"seed is 1099511627776; it is in \[0, 4294967293\]"),
        (2**32 - 2, r"it is in \[0, 4294967293\]"),  # The last environment has seed + 2.
        ("7", r"seed is '7'; it is an integer in"),
        (1.5, r"seed is 1.5; it is an integer in"),
        ([1, -2, 3], r"seed\[1\] is -2; it is in \[0, 4294967295\]"),
    ],
)
def test_seed_out_of_range_is_rejected(
    vector: ProcgenVectorEnv, seed: object, message: str
) -> None:
    with pytest.raises(errors.InvalidArgumentError, match=message):
        vector.reset(seed=seed)


def test_largest_seed_of_one_environment_is_accepted(single: ProcgenGymEnv) -> None:
    single.reset(seed=2**32 - 1)
    with pytest.raises(errors.InvalidArgumentError, match=r"it is in \[0, 4294967295\]"):
        single.reset(seed=2**32)


def test_closed_environments_say_so() -> None:
    vector = ProcgenVectorEnv("maze", 2)
    single = ProcgenGymEnv("maze")
    single.reset()
    single.step(-1)
    for env in (vector, single):
        env.close()
        for call in (env.reset, lambda env=env: env.step([4, 4])):
            with pytest.raises(errors.FailedPreconditionError, match="the environment is closed"):
                call()
