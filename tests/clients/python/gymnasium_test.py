"""What is different where Gymnasium is installed: base class, enumeration and spaces are its own.

Debian has no Gymnasium. Where it is missing, a few lines with its names take its place on the path
of a second Python: they show that ours finds and uses what Gymnasium 1.4.0 exports under these
names, and nothing about Gymnasium itself.
"""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

from procgen_client import ServerProcess

_IN_ITS_PLACE = {
    # gymnasium/__init__.py exports spaces and vector.
    "__init__.py": "from gymnasium import spaces, vector\n",
    # gymnasium/spaces/box.py and discrete.py: Box(low, high, shape, dtype), Discrete(n).
    "spaces.py": """
from dataclasses import dataclass

@dataclass
class Box:
    low: int
    high: int
    shape: tuple
    dtype: type

@dataclass
class Discrete:
    n: int
""",
    # gymnasium/vector/__init__.py exports AutoresetMode and VectorEnv (vector/vector_env.py).
    "vector/__init__.py": """
import enum

class AutoresetMode(enum.Enum):
    NEXT_STEP = "NextStep"
    SAME_STEP = "SameStep"
    DISABLED = "Disabled"

class VectorEnv:
    metadata = {}
    spec = None
    render_mode = None
    closed = False

    def close(self, **kwargs):
        if not self.closed:
            self.close_extras(**kwargs)
            self.closed = True
""",
    # gymnasium/vector/utils/space_utils.py: batch_space(space, n).
    "vector/utils.py": """
def batch_space(space, n):
    return (space, n)
""",
}

_PROGRAM = """
import sys
import gymnasium
import numpy as np
from procgen_client import AutoresetMode, ProcgenVectorEnv

assert AutoresetMode is gymnasium.vector.AutoresetMode
assert issubclass(ProcgenVectorEnv, gymnasium.vector.VectorEnv)
env = ProcgenVectorEnv("maze", 2, server=sys.argv[1], autoreset_mode="SameStep")
assert env.metadata["autoreset_mode"] is gymnasium.vector.AutoresetMode.SAME_STEP
box, discrete = gymnasium.spaces.Box(0, 255, (64, 64, 3), np.uint8), gymnasium.spaces.Discrete(15)
assert env.single_observation_space == box
assert env.single_action_space == discrete
batch_space = gymnasium.vector.utils.batch_space
assert env.observation_space == batch_space(box, 2)
assert env.action_space == batch_space(discrete, 2)
env.reset(seed=1)
env.step([0, -1])
env.close()
env.close()
assert env.closed

atari = {"screen_size": 84, "grayscale_obs": True, "frame_stack": 4}
with ProcgenVectorEnv("maze", 2, server=sys.argv[1], **atari) as env:
    box = gymnasium.spaces.Box(0, 255, (4, 84, 84, 1), np.uint8)
    assert env.single_observation_space == box
    assert env.observation_space == batch_space(box, 2)
"""


@pytest.fixture
def path(tmp_path: Path) -> str:
    """Where the second Python looks for modules."""
    if importlib.util.find_spec("gymnasium") is None:
        for name, text in _IN_ITS_PLACE.items():
            file = tmp_path / "gymnasium" / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
    return os.pathsep.join([str(tmp_path), *sys.path])


def test_gymnasiums_classes_and_spaces_are_used(server: ServerProcess, path: str) -> None:
    result = subprocess.run(
        [sys.executable, "-c", _PROGRAM, server.address],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
