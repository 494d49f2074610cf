"""With Gymnasium installed, the client uses its base classes, enumeration and spaces.

Debian has no Gymnasium. Where it is missing, a stub package replaces it in a second Python process.
The stub has the exported names of Gymnasium 1.4.0, 1.0.0 and 0.29.1. The tests show that the client
finds and uses these names; they do not test Gymnasium.
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
    # It and gymnasium/core.py: Env; gymnasium/envs/registration.py: register, make, make_vec, which
    # hands the keyword arguments of both to the entry point.
    "__init__.py": """
import importlib
from gymnasium import spaces, vector

__version__ = "VERSION"

class Env:
    metadata = {}
    spec = None

    @property
    def unwrapped(self):
        return self

    def reset(self, *, seed=None, options=None):
        self.was_seeded_with = seed

registry = {}

def register(id, entry_point=None, vector_entry_point=None, kwargs=None):
    registry[id] = (entry_point, vector_entry_point, kwargs or {})

def _load(name):
    module, attribute = name.split(":")
    return getattr(importlib.import_module(module), attribute)

class EnvSpec:
    def __init__(self, id, max_episode_steps):
        self.id, self.max_episode_steps = id, max_episode_steps

def make(id, **kwargs):
    # It assigns a minimal spec without max_episode_steps, and adds the wrapper TimeLimit if the
    # registered one has them.
    env = _load(registry[id][0])(**(registry[id][2] | kwargs))
    env.unwrapped.spec = EnvSpec(id, max_episode_steps=None)
    return env

def make_vec(id, num_envs=1, **kwargs):
    if registry[id][1] is None:  # envs/registration.py: vectorises what entry_point makes.
        return [make(id, **kwargs) for _ in range(num_envs)]
    env = _load(registry[id][1])(num_envs=num_envs, **(registry[id][2] | kwargs))
    env.unwrapped.spec = id
    return env
""",
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

@dataclass
class Dict:
    spaces: dict
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

    @property
    def unwrapped(self):
        return self

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

# gymnasium/vector/__init__.py before 1.1 has no AutoresetMode, and before 1.0 another VectorEnv.
_VECTOR_BEFORE_1_1 = _IN_ITS_PLACE["vector/__init__.py"].replace("AutoresetMode", "_Mode")
_VECTOR_BEFORE_1_0 = """
from gymnasium import Env

class VectorEnv(Env):
    def __init__(self, num_envs, observation_space, action_space):
        raise AssertionError("this contract is another")
"""

_PROGRAM_BEFORE_1_1 = """
import sys
import warnings
import gymnasium
import numpy as np

warnings.simplefilter("error")
from procgen_client import AutoresetMode, ProcgenGymEnv, ProcgenVectorEnv

is_1_0 = gymnasium.__version__ == "1.0.0"
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    env = ProcgenVectorEnv("maze", 2)
assert len(caught) == (0 if is_1_0 else 1)
assert is_1_0 or "Gymnasium 0.29.1 is installed" in str(caught[0].message)
assert is_1_0 or caught[0].filename == sys.argv[0]
assert issubclass(ProcgenVectorEnv, gymnasium.vector.VectorEnv) == is_1_0
assert env.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
assert env.single_action_space == gymnasium.spaces.Discrete(15)
assert env.action_space == gymnasium.vector.utils.batch_space(gymnasium.spaces.Discrete(15), 2)
env.reset(seed=1)
env.step([0, -1])
env.close()

assert issubclass(ProcgenGymEnv, gymnasium.Env)
for name in ("procgen_server/maze-v0", "procgen-maze-v0"):
    one = gymnasium.make(name)
    assert isinstance(one.observation_space, gymnasium.spaces.Box)
    one.reset(seed=5)
    one.step(4)
    one.close()
several = gymnasium.make_vec("procgen_server/maze-v0", num_envs=2)
assert isinstance(several, ProcgenVectorEnv if is_1_0 else list)
"""

_PROGRAM = """
import sys
import gymnasium
import numpy as np
from procgen_client import AutoresetMode, ProcgenEnv, ProcgenGymEnv, ProcgenVectorEnv

assert AutoresetMode is gymnasium.vector.AutoresetMode
assert issubclass(ProcgenVectorEnv, gymnasium.vector.VectorEnv)
env = ProcgenVectorEnv("maze", 2, autoreset_mode="SameStep")
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

# gymnasium/envs/registration.py, make_vec: a vector_entry_point is called with num_envs and the
# registered keyword arguments; spec is set. Ours: a namespace of its own.
# And upstream's ids, which are Gym's: procgen-coinrun-v0.
assert len(gymnasium.registry) == 32
vector = gymnasium.make_vec("procgen_server/coinrun-v0", num_envs=3)
assert isinstance(vector, ProcgenVectorEnv)
assert vector.pool.games == ("coinrun",)
assert vector.num_envs == 3
vector.close()

one = gymnasium.make("procgen_server/maze-v0", render_mode="rgb_array")
assert isinstance(one, ProcgenGymEnv)
assert issubclass(ProcgenGymEnv, gymnasium.Env)
assert one.observation_space == gymnasium.spaces.Box(0, 255, (64, 64, 3), np.uint8)
assert one.action_space == gymnasium.spaces.Discrete(15)
one.reset(seed=5)
assert one.was_seeded_with == 5, "core.py, Env.reset: subclasses call it"
one.step(4)
assert one.render().shape == (512, 512, 3)
one.close()

# Ours: the time limit is the environment's own; its spec has it for programs that read it there.
for game, limit, options in (
    ("maze", 500, {}),
    ("bigfish", 6000, {}),
    ("jumper", 2000, {"distribution_mode": "memory"}),
    ("coinrun", 250, {"frame_skip": 4}),
):
    one = gymnasium.make(f"procgen_server/{game}-v0", **options)
    assert one.spec.max_episode_steps == limit, game
    assert one.spec.id == f"procgen_server/{game}-v0"
    one.close()
assert ProcgenGymEnv("maze").spec is None

venv = ProcgenEnv(1, "maze")
assert isinstance(venv.observation_space, gymnasium.spaces.Dict)
venv.close()

atari = {"screen_size": 84, "grayscale_obs": True, "frame_stack": 4}
with ProcgenVectorEnv("maze", 2, **atari) as env:
    box = gymnasium.spaces.Box(0, 255, (4, 84, 84, 1), np.uint8)
    assert env.single_observation_space == box
    assert env.observation_space == batch_space(box, 2)
"""


def _install(folder: Path, version: str) -> None:
    vector = {"1.0.0": _VECTOR_BEFORE_1_1, "0.29.1": _VECTOR_BEFORE_1_0}
    modules = _IN_ITS_PLACE | {
        "__init__.py": _IN_ITS_PLACE["__init__.py"].replace("VERSION", version)
    }
    if version in vector:
        modules["vector/__init__.py"] = vector[version]
    if version == "0.29.1":  # There, VectorEnv is a subclass of Env.
        body = modules["__init__.py"].replace("from gymnasium import spaces, vector\n", "")
        modules["__init__.py"] = body + "\nfrom gymnasium import spaces, vector\n"
    for name, text in modules.items():
        file = folder / "gymnasium" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)


def _run(program: str, folder: Path, server: ServerProcess) -> None:
    file = folder / "program.py"
    file.write_text(program)
    result = subprocess.run(
        [sys.executable, str(file), server.address],
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(folder), *sys.path])},
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr


def test_gymnasium_classes_and_spaces_are_used(server: ServerProcess, tmp_path: Path) -> None:
    if importlib.util.find_spec("gymnasium") is None:
        _install(tmp_path, "1.4.0")
    _run(_PROGRAM, tmp_path, server)


@pytest.mark.parametrize("version", ["1.0.0", "0.29.1"])
def test_older_gymnasium_versions_are_supported(
    version: str, server: ServerProcess, tmp_path: Path
) -> None:
    _install(tmp_path, version)
    _run(_PROGRAM_BEFORE_1_1, tmp_path, server)
