"""A learner of the Python client; hostile_test.py describes its output."""

from __future__ import annotations

import json
import sys
import zlib

import numpy as np

from procgen_client import Batch, Client, ProcgenError

_ENV_COUNT = 5


def _digest(before: int, batch: Batch) -> int:
    for values in (batch.observations, batch.rewards, batch.fingerprints, batch.final_observations):
        before = zlib.crc32(np.ascontiguousarray(values).tobytes(), before)
    return before


def _learn(address: str, encoding: str) -> int:
    with Client(address, timeout=5, call_timeout=5, reconnect_timeout=1) as client:
        pool = client.create_pool(
            "coinrun",
            _ENV_COUNT,
            distribution_mode="easy",
            rand_seed=5,
            encoding=encoding,
            transport="stream",
        )
        digest = _digest(0, pool.observe())
        for step in range(10):
            actions = [(step * 31 + i * 17) % 16 - 1 for i in range(_ENV_COUNT)]
            digest = _digest(digest, pool.step(actions, final_observations=True))
        pool.detach()
        for snapshot in pool.save_states([2, 0]):
            digest = zlib.crc32(len(snapshot).to_bytes(4, "little"), digest)
        for frame in pool.render([1, 3], size_px=64):
            digest = zlib.crc32(frame.tobytes(), digest)
        pool.get_episode(0, "current")
        client.list_pools()
        pool.close()
        return digest


for argument in sys.argv[1:]:
    mode, encoding, address = argument.split("=")
    print(f"begin {mode}", flush=True)
    try:
        report = {"digest": _learn(address, encoding)}
    except ProcgenError as error:
        report = {"error": type(error).__name__, "message": str(error)}
    print(json.dumps({"mode": mode, **report}), flush=True)
