"""What Stable-Baselines3's wrappers of vector environments expect of ProcgenEnv.

Debian has no Stable-Baselines3. The wrappers below are in brief those of its version 2.4.1, with
the source of each. Where it is installed, its own are used.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from procgen_client import ProcgenEnv, ProcgenVectorEnv

_N = 3


class _VecEnvWrapper:
    """As common/vec_env/base_vec_env.py: its attributes are read, its two halves of step called."""

    def __init__(self, venv: Any) -> None:  # noqa: ANN401
        self.venv, self.num_envs = venv, venv.num_envs
        self.observation_space, self.action_space = venv.observation_space, venv.action_space
        self.render_mode = venv.render_mode

    def step(self, actions: np.ndarray) -> tuple[Any, ...]:
        self.step_async(actions)
        return self.step_wait()

    def step_async(self, actions: np.ndarray) -> None:
        self.venv.step_async(actions)

    def close(self) -> None:
        self.venv.close()


class _VecExtractDictObs(_VecEnvWrapper):
    """As common/vec_env/vec_extract_dict_obs.py."""

    def __init__(self, venv: Any, key: str) -> None:  # noqa: ANN401
        super().__init__(venv)
        self.key, self.observation_space = key, venv.observation_space.spaces[key]

    def reset(self) -> np.ndarray:
        return self.venv.reset()[self.key]

    def step_wait(self) -> tuple[Any, ...]:
        observations, rewards, dones, infos = self.venv.step_wait()
        for info in infos:
            if "terminal_observation" in info:
                info["terminal_observation"] = info["terminal_observation"][self.key]
        return observations[self.key], rewards, dones, infos


class _VecFrameStack(_VecEnvWrapper):
    """As common/vec_env/vec_frame_stack.py: stacks the frames in the channels, the newest last."""

    def __init__(self, venv: Any, count: int) -> None:  # noqa: ANN401
        super().__init__(venv)
        height, width, channels = venv.observation_space.shape
        self.stack = np.zeros([self.num_envs, height, width, count * channels], np.uint8)
        self.channels = channels

    def reset(self) -> np.ndarray:
        self.stack[:] = 0
        return self._stacked(self.venv.reset())

    def step_wait(self) -> tuple[Any, ...]:
        observations, rewards, dones, infos = self.venv.step_wait()
        self.stack[dones] = 0
        return self._stacked(observations), rewards, dones, infos

    def _stacked(self, observations: np.ndarray) -> np.ndarray:
        self.stack = np.roll(self.stack, -self.channels, -1)
        self.stack[..., -self.channels :] = observations
        return self.stack


@pytest.fixture(params=["brief", "installed"])
def wrappers(request: pytest.FixtureRequest) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """VecExtractDictObs and VecFrameStack."""
    if request.param == "brief":
        return _VecExtractDictObs, _VecFrameStack
    library = pytest.importorskip("stable_baselines3.common.vec_env")
    return library.VecExtractDictObs, library.VecFrameStack


def test_procgen_env_passes_through_its_wrappers(
    wrappers: tuple[Callable[..., Any], Callable[..., Any]]
) -> None:
    extract, stack = wrappers
    env = stack(extract(ProcgenEnv(_N, "coinrun", rand_seed=1), "rgb"), 4)
    plain = ProcgenEnv(_N, "coinrun", rand_seed=1)
    assert env.reset().shape == (_N, 64, 64, 12)
    plain.reset()
    for action in (7, -1, 4):
        observations, rewards, dones, infos = env.step(np.full(_N, action))
        expected = plain.step(np.full(_N, action))
        np.testing.assert_array_equal(observations[..., -3:], expected[0]["rgb"])
        np.testing.assert_array_equal(rewards, expected[1])
        np.testing.assert_array_equal(dones, expected[2])
        assert dones.all() == (action == -1)
        assert len(infos) == _N
    env.close()
    plain.close()


def test_frame_stack_adds_an_axis_that_its_networks_do_not_take() -> None:
    # common/preprocessing.py, is_image_space: an image has three axes.
    with ProcgenVectorEnv("coinrun", 1, frame_stack=4) as env:
        assert env.single_observation_space.shape == (4, 64, 64, 3)
    with ProcgenVectorEnv("coinrun", 1, layout="chw") as env:
        assert env.single_observation_space.shape == (3, 64, 64)
