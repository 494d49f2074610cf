"""PPO learns: the return rises."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from small_runs import options

from learners import ppo
from procgen_client import ServerProcess


def test_the_return_rises(server: ServerProcess, tmp_path: Path) -> None:
    words = options(tmp_path, server.address, game="fruitbot", levels=1, total_steps=1)
    assert ppo.main(words) == 0
    with open(tmp_path / "episodes.csv", newline="") as file:
        returns = [float(row["return"]) for row in csv.DictReader(file)]
    assert np.mean(returns[-100:]) > np.mean(returns[:100])
