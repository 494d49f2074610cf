"""A learner in a thread."""

from __future__ import annotations

import threading

import numpy as np

from procgen_client import Pool


class Learner:
    """Steps a pool in a thread until stop()."""

    def __init__(self, pool: Pool) -> None:
        self.pool = pool
        self._stops = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        actions = np.full(self.pool.env_count, 7)
        while not self._stops.is_set():
            self.pool.step(actions)

    def stop(self) -> None:
        self._stops.set()
        self._thread.join()
