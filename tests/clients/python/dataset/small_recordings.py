"""Small recordings, and writers that keep frames."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from procgen_client.dataset import Block, Trajectories, from_actions, parts_of, record

OPTIONS = {"distribution_mode": "easy", "num_levels": 20}


class Frames:
    """Keeps all frames: uint8 [N, T + 1, *F]."""

    needs_final_observations = False

    def __init__(self, block_length: int = 16) -> None:
        """Takes the number of steps in a block."""
        self.block_length = block_length
        self.blocks: list[np.ndarray] = []

    def write(self, block: Block) -> None:
        """Copies the observations."""
        assert block.observations is not None
        assert block.start == sum(map(len, self.blocks)) - len(self.blocks)
        self.blocks.append(block.observations.copy())

    @property
    def all(self) -> np.ndarray:
        """The frames; the last of each block is the first of the next."""
        for one, other in zip(self.blocks, self.blocks[1:]):
            np.testing.assert_array_equal(one[-1], other[0])
        rows = [block[:-1] for block in self.blocks[:-1]] + self.blocks[-1:]
        return np.concatenate(rows).swapaxes(0, 1)


def small_trajectories(
    game: str = "bigfish", env_count: int = 3, step_count: int = 100, **options: Any
) -> Trajectories:
    """Random actions, and some that end an episode."""
    actions = np.random.default_rng(5).integers(-1, 15, (env_count, step_count))
    return from_actions(game, actions, **{"rand_seed": 3, **OPTIONS, **options})


def recorded(folder: Path, game: str = "bigfish", **options: Any) -> list[Path]:
    """Records in this process; returns the files."""
    parts = parts_of(folder, game, **{"step_count": 4096, "options": OPTIONS, **options})
    folder.mkdir(exist_ok=True)
    for part in parts:
        record(part)
    return [part.path for part in parts]
