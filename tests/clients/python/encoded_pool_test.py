"""Pools with encoded observations return the same batches as raw pools."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import assert_same

from procgen_client import Client, Pool, Reset

_ENCODING = "delta_zstd"
_FORMATS: dict[str, dict[str, Any]] = {
    "default": {},
    "grey stack": {"grayscale_obs": True, "screen_size": 84, "frame_stack": 4},
    "odd planes": {"layout": "chw", "screen_size": 43},
}
_OPTIONS: dict[str, Any] = {"distribution_mode": "easy", "rand_seed": 7}
_ENV_COUNT = 5
_IN_FLIGHT = 3


def send_any(pool: Pool, rng: np.random.Generator) -> None:
    """Sends a random request for a slice; some request no observations."""
    first = int(rng.integers(_ENV_COUNT))
    count = int(rng.integers(1, _ENV_COUNT - first + 1))
    kind = int(rng.integers(6))
    observe = bool(rng.integers(4))
    actions = rng.integers(-1, 15, count)
    if kind == 0:
        pool.send_observe(first_env=first, env_count=count, observe=observe)
    elif kind == 1:
        pool.send_reset([first], first_env=first, env_count=count, observe=observe)
    else:
        pool.send_step(
            actions,
            first_env=first,
            env_count=count,
            observe=observe,
            repeat_count=kind - 1,
            final_observations=kind % 2 == 0,
            resets=[Reset(first)] if kind == 5 else [],
        )


def assert_equal_batches(raw: Pool, encoded: Pool, request_count: int, seed: int) -> None:
    rngs = [np.random.default_rng(seed) for _ in range(2)]
    for _ in range(request_count):
        for pool, rng in zip((raw, encoded), rngs, strict=True):
            while pool.in_flight < _IN_FLIGHT:
                send_any(pool, rng)
        assert_same(raw.receive(), encoded.receive())
    for _ in range(raw.in_flight):
        assert_same(raw.receive(), encoded.receive())


@pytest.mark.parametrize("form", _FORMATS)
def test_encoded_batches_equal_raw_ones(client: Client, form: str) -> None:
    options = _OPTIONS | _FORMATS[form]
    with (
        client.create_pool("fruitbot", _ENV_COUNT, **options) as raw,
        client.create_pool("fruitbot", _ENV_COUNT, encoding=_ENCODING, **options) as encoded,
    ):
        assert_equal_batches(raw, encoded, request_count=200, seed=3)
        states = raw.save_states()
        assert encoded.save_states() == states
        assert_equal_batches(raw, encoded, request_count=10, seed=2)
        for pool in (raw, encoded):
            pool.restore_states(states)
        assert_same(raw.observe(), encoded.observe())
        assert_equal_batches(raw, encoded, request_count=10, seed=4)


def test_encoded_batches_of_several_answers_equal_raw_ones(client: Client) -> None:
    with (
        client.create_pool("maze", 700, **_OPTIONS) as raw,
        client.create_pool("maze", 700, encoding=_ENCODING, **_OPTIONS) as encoded,
    ):
        for t in range(5):
            actions = np.random.default_rng(t).integers(-1, 15, 700)
            assert_same(
                raw.step(actions, final_observations=True),
                encoded.step(actions, final_observations=True),
            )
