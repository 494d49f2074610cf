"""Settings of worlds and of resets, and the tensors that they are."""

from __future__ import annotations

from types import ModuleType as Module

import numpy as np
import numpy.typing as npt
import pytest
from conftest import Agent, Protocol, rejected

from procgen_client.errors import InvalidArgumentError

INVALID_ARGUMENT = 3
LEVEL_SEED = 3


@pytest.fixture
def tensors(protocol: Protocol) -> Module:
    """The module, which imports the generated code."""
    from procgen_client.dm_env_rpc import _tensors

    return _tensors


class TestWorlds:
    def test_defaults_are_those_of_upstream(self, protocol: Protocol) -> None:
        from procgen_client.dm_env_rpc._settings import pool_arguments

        assert pool_arguments({"env_name": protocol.pack("maze")}) == {
            "games": "maze", "env_count": 1, "autoreset_mode": "disabled", "num_threads": 0,
        }

    def test_every_setting_is_an_option_of_the_pool(self, protocol: Protocol) -> None:
        from procgen_client.dm_env_rpc._settings import pool_arguments

        options = {
            "distribution_mode": "memory", "num_levels": 4, "start_level": 5, "rand_seed": -6,
            "use_sequential_levels": True, "center_agent": False, "use_backgrounds": False,
            "use_generated_assets": True, "use_monochrome_assets": True, "restrict_themes": True,
            "paint_vel_info": True, "debug_mode": 14, "screen_size": 84, "grayscale_obs": True,
            "layout": "chw", "frame_stack": 4, "first_env": 2, "total_env_count": 9,
            "pool_id": "mine",
        }
        given = {**options, "env_name": ["maze", "coinrun"], "num_envs": 3, "distribution_mode": 10}
        assert pool_arguments({name: protocol.pack(value) for name, value in given.items()}) == {
            **options, "games": ["maze", "coinrun"], "env_count": 3, "autoreset_mode": "same_step",
        }

    def test_settings_change_the_observation(self, agent: Agent) -> None:
        specs = agent.join(agent.create(
            env_name="maze", num_envs=2, screen_size=84, grayscale_obs=1, layout="chw",
            frame_stack=4,
        ))
        assert list(specs.observations[1].shape) == [2, 4, 1, 84, 84]
        assert agent.step(observations=[1]).observations[1].shape == (2, 4, 1, 84, 84)

    def test_the_program_has_settings_of_its_own(self, agent: Agent) -> None:
        for name in ("server", "art", "autoreset_mode", "num_threads", "encoding"):
            with rejected(INVALID_ARGUMENT, f"create_world has no option '{name}'"):
                agent.create(env_name="maze", **{name: 1})



class TestResets:
    def test_a_scalar_is_the_level_of_all_and_the_first_of_successive_seeds(
        self, protocol: Protocol
    ) -> None:
        from procgen_client.dm_env_rpc._settings import episode_settings

        given = {"level_seed": protocol.pack(8), "rand_seed": protocol.pack(2**63 - 1)}
        levels, seeds = episode_settings(given, 2)
        assert levels == {0: 8, 1: 8}
        assert seeds == {0: 2**32 - 1, 1: 0}

    def test_a_batch_takes_a_value_for_each_environment(self, agent: Agent) -> None:
        agent.join(agent.create(env_name="maze", num_envs=2))
        agent.reset(level_seed=[4, 5])
        seeds = agent.step(observations=[LEVEL_SEED]).observations[LEVEL_SEED]
        np.testing.assert_array_equal(seeds, [4, 5])
        with rejected(INVALID_ARGUMENT, r"level_seed has shape \[3\] and 3 elements, allowed: sha"):
            agent.reset(level_seed=[4, 5, 6])

    def test_a_level_seed_has_32_bits(self, joined: Agent) -> None:
        with rejected(INVALID_ARGUMENT, "level_seed is 2147483648"):
            joined.reset(level_seed=2**31)


class TestTensors:
    @pytest.mark.parametrize(
        ("elements", "shape", "length", "expected"),
        [
            ([5], [], None, 5),
            ([1, 2], [2], 2, [1, 2]),
            ([7], [3], 3, [7, 7, 7]),  # One element is broadcast.
            ([1, 2], [-1], 2, [1, 2]),  # A negative dimension is inferred.
        ],
    )
    def test_shapes_are_read(
        self, protocol: Protocol, tensors: Module, elements: list[int], shape: list[int],
        length: int | None, expected: int | list[int],
    ) -> None:
        tensor = protocol.pb2.Tensor(shape=shape)
        tensor.int32s.array.extend(elements)
        assert tensors.unpack("x", tensor, tensors.INT32, length) == expected

    @pytest.mark.parametrize(
        ("elements", "shape", "length"),
        [
            ([5], [1], None), ([], [], None), ([5, 6], [], None), ([5, 6], [2], 3),
            ([5, 6], [3], 3), ([], [0], 3), ([1, 2, 3], [3, 1], 3), ([5], [-1, -1], 1),
            ([7], [-1], 3), ([1], [1] * 100, None), ([1], [2**31 - 1], -1),
        ],
    )
    def test_other_shapes_are_named(
        self, protocol: Protocol, tensors: Module, elements: list[int], shape: list[int],
        length: int | None,
    ) -> None:
        tensor = protocol.pb2.Tensor(shape=shape)
        tensor.int32s.array.extend(elements)
        with pytest.raises(InvalidArgumentError, match=r"x has shape \[.{0,40}\] and . elements"):
            tensors.unpack("x", tensor, tensors.INT32, length)

    def test_integers_have_any_integer_type(self, protocol: Protocol, tensors: Module) -> None:
        for value in (np.int8(-2), np.uint8(254), np.int32(-9), np.uint32(2**32 - 1),
                      np.int64(-(2**63)), np.uint64(2**64 - 1)):
            assert tensors.unpack("x", protocol.pack(value), tensors.INTEGER, None) == int(value)
        with pytest.raises(InvalidArgumentError, match="x has type DOUBLE, allowed: an integer"):
            tensors.unpack("x", protocol.pack(1.0), tensors.INTEGER, None)
        with pytest.raises(InvalidArgumentError, match="x has type none, allowed: an integer"):
            tensors.unpack("x", protocol.pb2.Tensor(), tensors.INTEGER, None)

    @pytest.mark.parametrize(
        "value",
        [1.5, True, np.uint8([1, 2]), np.float32([0.5]), np.bool_([True])],
    )
    def test_packed_values_are_read(
        self, protocol: Protocol, tensors: Module, value: npt.ArrayLike
    ) -> None:
        tensor = protocol.pb2.Tensor()
        tensors.pack(value, tensor)
        assert tensor == protocol.pack(value)
        length = tensors.ANY if np.ndim(value) else None
        assert tensors.unpack("x", tensor, tensors.VALUE, length) == np.asarray(value).tolist()
