"""Observation formats: colors, layouts, sizes and stacks.

The expected values are default observations of a pool with the same seeds, converted by numpy.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from conftest import MakePool, server_binary

from procgen_client import Client, ServerProcess
from procgen_client.errors import InvalidArgumentError, ResourceExhaustedError

_OPTIONS: dict[str, Any] = {"distribution_mode": "easy", "rand_seed": 7}


def _grey(rgb: np.ndarray) -> np.ndarray:
    luma = rgb.astype(np.int32) @ np.array([77, 150, 29])
    return ((luma + 128) // 256).astype(np.uint8)[..., np.newaxis]


def test_colors_and_layouts_are_converted_from_the_default_observation(
    make_pool: MakePool,
) -> None:
    rgb = make_pool("coinrun", 3, **_OPTIONS)
    planes = make_pool("coinrun", 3, layout="chw", **_OPTIONS)
    grey = make_pool("coinrun", 3, grayscale_obs=True, **_OPTIONS)
    assert planes.observation_shape == (3, 64, 64)
    assert grey.observation_shape == (64, 64, 1)
    for action in (7, 7, 4, 2, -1, 8):
        frames = rgb.step([action] * 3).observations
        np.testing.assert_array_equal(
            planes.step([action] * 3).observations, frames.transpose(0, 3, 1, 2)
        )
        np.testing.assert_array_equal(grey.step([action] * 3).observations, _grey(frames))


@pytest.mark.parametrize("screen_size", [16, 84, 512])
def test_observations_have_the_requested_size(make_pool: MakePool, screen_size: int) -> None:
    observations = make_pool("maze", 2, screen_size=screen_size, **_OPTIONS).observe().observations
    assert observations.shape == (2, screen_size, screen_size, 3)
    assert observations.std() > 10


def test_observations_beyond_the_default_response_limit_are_received(make_pool: MakePool) -> None:
    pool = make_pool("maze", 2, screen_size=512, frame_stack=16, **_OPTIONS)
    batch = pool.step([4, -1], final_observations=True)
    assert batch.observations.shape == (2, 16, 512, 512, 3)
    assert batch.final_observations.shape == (2, 16, 512, 512, 3)
    assert batch.observations[0, 15].any()
    assert batch.final_observations[1, 15].any()


@pytest.mark.parametrize(
    ("argument", "message"),
    [
        ({"screen_size": 15}, "screen_size is 15; it is in [16, 512]"),
        ({"frame_stack": 0}, "frame_stack is 0; it is in [1, 16]"),
        ({"screen_size": 84.5}, "screen_size is 84.5; it is an integer in [16, 512]"),
    ],
)
def test_formats_out_of_range_are_rejected(
    make_pool: MakePool, argument: dict[str, Any], message: str
) -> None:
    with pytest.raises(InvalidArgumentError) as raised:
        make_pool("maze", 1, **argument)
    assert message in raised.value.message


def test_observations_beyond_the_servers_limit_are_rejected() -> None:
    with ServerProcess(server_binary(), ["--owner_bytes_max=65536"]) as server:
        with Client(server.address) as client, pytest.raises(ResourceExhaustedError) as raised:
            client.create_pool("maze", 6)
    assert "limit owner_bytes_max is 65536" in raised.value.message
