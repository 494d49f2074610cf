"""`out=` receives observations in arrays and tensors of the caller."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from conftest import MakePool

from procgen_client import Client, Pool, ProcgenVectorEnv, errors

_N = 4
_FRAME = (64, 64, 3)


@pytest.fixture
def pools(make_pool: MakePool) -> tuple[Pool, Pool]:
    """A pool, and another with equal episodes."""
    return make_pool("bigfish", _N, rand_seed=3), make_pool("bigfish", _N, rand_seed=3)


def _outs() -> dict[str, Any]:
    outs: dict[str, Any] = {
        "array": np.zeros((_N, *_FRAME), np.uint8),
        "row": np.zeros((2, _N, *_FRAME), np.uint8)[1],
        "buffer": memoryview(bytearray(_N * 64 * 64 * 3)).cast("B", (_N, *_FRAME)),
    }
    try:
        import torch
    except ImportError:
        return outs
    outs["tensor"] = torch.zeros((_N, *_FRAME), dtype=torch.uint8)
    outs["row of a tensor"] = torch.zeros((2, _N, *_FRAME), dtype=torch.uint8)[1]
    if torch.cuda.is_available():
        outs["pinned tensor"] = torch.zeros((_N, *_FRAME), dtype=torch.uint8).pin_memory()
    return outs


@pytest.mark.parametrize("out", [pytest.param(out, id=name) for name, out in _outs().items()])
def test_observations_are_written_into_out(pools: tuple[Pool, Pool], out: object) -> None:
    pool, twin = pools
    for call, arguments in (("observe", ()), ("step", ([7] * _N,)), ("reset", ())):
        batch = getattr(pool, call)(*arguments, out=out)
        assert batch.observations is out
        expected = getattr(twin, call)(*arguments)
        np.testing.assert_array_equal(np.asarray(out), expected.observations)
        np.testing.assert_array_equal(batch.rewards, expected.rewards)


def test_halves_are_written_into_rows_of_one_array(pools: tuple[Pool, Pool]) -> None:
    pool, twin = pools
    observations = np.zeros((_N, *_FRAME), np.uint8)
    for first in (0, 2):
        rows = observations[first : first + 2]
        pool.send_observe(first_env=first, env_count=2, out=rows)
    for _ in range(2):
        assert pool.receive().observations.base is observations
    np.testing.assert_array_equal(observations, twin.observe().observations)


def test_batch_with_out_is_not_used_for_later_ones(pools: tuple[Pool, Pool]) -> None:
    pool, twin = pools
    out = np.zeros((_N, *_FRAME), np.uint8)
    pool.step([7] * _N, out=out)
    written = out.copy()
    for arguments in ({}, {"observe": False}):
        batch = pool.step([7] * _N, **arguments)
        assert batch.observations is not out
        np.testing.assert_array_equal(out, written)
    twin.step([7] * _N, repeat_count=3)
    np.testing.assert_array_equal(pool.observe().observations, twin.observe().observations)


def test_env_writes_into_out(place: Client | None) -> None:
    with (
        ProcgenVectorEnv("maze", _N, rand_seed=1, server=place) as env,
        ProcgenVectorEnv("maze", _N, rand_seed=1, server=place) as twin,
    ):
        buffer = np.zeros((4, _N, *_FRAME), np.uint8)
        first, _ = env.reset(out=buffer[0])
        stepped = env.step([7] * _N, out=buffer[1])[0]
        env.step_async([5] * _N)
        waited = env.step_wait(out=buffer[2])[0]
        again, _ = env.reset(seed=4, out=buffer[3])
        expected = (
            twin.reset()[0],
            twin.step([7] * _N)[0],
            twin.step([5] * _N)[0],
            twin.reset(seed=4)[0],
        )
        for observations, row, others in zip(
            (first, stepped, waited, again), buffer, expected, strict=True
        ):
            assert observations.base is buffer
            np.testing.assert_array_equal(row, others)


_READ_ONLY = np.zeros((_N, *_FRAME), np.uint8)
_READ_ONLY.flags.writeable = False
_ALLOWED = r"it is a writable, C-contiguous uint8 array of shape \[4, 64, 64, 3\]"


@pytest.mark.parametrize(
    ("out", "message"),
    [
        (np.zeros((3, *_FRAME), np.uint8), r"out has shape \[3, 64, 64, 3\]; " + _ALLOWED),
        (np.zeros((_N, 64, 64), np.uint8), r"out has shape \[4, 64, 64\]; "),
        (np.zeros((_N, *_FRAME), np.float32), "out has type float32; " + _ALLOWED),
        (np.zeros((_N, *_FRAME), np.int8), "out has type int8; "),
        (np.zeros((_N, 64, 64, 6), np.uint8)[..., ::2], "out is not C-contiguous; " + _ALLOWED),
        (_READ_ONLY, "out is read-only; " + _ALLOWED),
        (bytes(12), "out is bytes; "),
        ([[1, 2], [3, 4]], "out is list; it is a numpy array, a tensor on the CPU or a buffer"),
        ("tensor", "out is str; "),
    ],
)
def test_other_outs_are_rejected_before_anything_is_sent(
    make_pool: MakePool, place: Client | None, out: Any, message: str  # noqa: ANN401
) -> None:
    pool = make_pool("maze", _N)
    calls = (pool.observe, pool.reset, lambda out: pool.step([7] * _N, out=out))
    for call in (*calls, pool.send_observe, pool.send_reset):
        with pytest.raises(errors.InvalidArgumentError, match=message):
            call(out=out)
    assert pool.in_flight == 0
    assert pool.step([7] * _N).episode_lengths.tolist() == [1] * _N
    with ProcgenVectorEnv("maze", _N, server=place) as env:
        env.reset()
        for call in (env.reset, lambda out: env.step([7] * _N, out=out)):
            with pytest.raises(errors.InvalidArgumentError, match=message):
                call(out=out)
        assert not env.pool.in_flight
        env.step_async([7] * _N)
        with pytest.raises(errors.InvalidArgumentError, match=message):
            env.step_wait(out=out)
        assert env.step_wait()[0].shape == (_N, *_FRAME)


def test_tensors_that_numpy_cannot_view_are_rejected() -> None:
    torch = pytest.importorskip("torch")
    with Pool("maze", 1) as pool:
        for tensor in (
            torch.zeros((1, *_FRAME), dtype=torch.uint8, device="meta"),
            torch.zeros((1, *_FRAME), requires_grad=True),
            torch.zeros((1, *_FRAME), dtype=torch.bfloat16),
        ):
            with pytest.raises(errors.InvalidArgumentError, match="out is Tensor; it is a numpy"):
                pool.observe(out=tensor)


def test_documented_ways_to_torch_neither_copy_nor_warn(place: Client | None) -> None:
    torch = pytest.importorskip("torch")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with ProcgenVectorEnv("maze", _N, server=place) as env:
            env.reset()
            tensor = torch.zeros((_N, *_FRAME), dtype=torch.uint8)
            assert env.step([7] * _N, out=tensor)[0] is tensor
            observations = env.step([7] * _N)[0]
            for made in (torch.from_numpy(observations), torch.from_dlpack(observations)):
                assert made.data_ptr() == observations.ctypes.data
            assert np.shares_memory(np.from_dlpack(observations), observations)
