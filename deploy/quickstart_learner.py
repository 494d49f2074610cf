#!/usr/bin/env python3
"""Steps a pool at watching speed until its servers stop.

deploy/quickstart.sh --keep starts it.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from procgen_client import ACTION_COUNT, Client, ProcgenError

_GAMES = ["coinrun", "starpilot", "caveflyer", "bigfish"]
_ENVIRONMENTS = 16
_STEPS_PER_SECOND = 15
# Steps per action, so that agents move around.
_HELD_STEPS = 5


def main() -> None:
    """Runs the program."""
    rng = np.random.default_rng(0)
    actions = rng.integers(0, ACTION_COUNT, _ENVIRONMENTS)
    with (
        Client(sys.argv[1], reconnect_timeout=5) as client,
        client.create_pool(
            _GAMES, _ENVIRONMENTS, pool_id="watch-me", distribution_mode="easy"
        ) as pool,
    ):
        while True:
            begin = time.perf_counter()
            pool.step(actions)
            changed = rng.random(_ENVIRONMENTS) < 1 / _HELD_STEPS
            actions = np.where(changed, rng.integers(0, ACTION_COUNT, _ENVIRONMENTS), actions)
            time.sleep(max(0.0, 1 / _STEPS_PER_SECOND - (time.perf_counter() - begin)))


if __name__ == "__main__":
    try:
        main()
    except ProcgenError:
        pass  # The servers have stopped.
