"""TorchRL's wrapper of Gymnasium's vector environments takes ours."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("torchrl")

import torch  # noqa: E402
from torchrl.envs import GymWrapper  # noqa: E402
from torchrl.envs.utils import check_env_specs  # noqa: E402

from procgen_client import ProcgenVectorEnv  # noqa: E402

_N = 4
_OPTIONS = {"distribution_mode": "easy", "rand_seed": 3, "autoreset_mode": "Disabled"}


def _wrapped(**options: object) -> GymWrapper:
    env = ProcgenVectorEnv("coinrun", _N, **(_OPTIONS | options))
    return GymWrapper(env, categorical_action_encoding=True)


def test_specs_match() -> None:
    env = _wrapped(layout="chw", frame_stack=2)
    assert env.batch_size == torch.Size([_N])
    check_env_specs(env)
    env.close()


def test_rollouts_have_the_values_of_the_environment() -> None:
    env = _wrapped()
    actions = np.array([[7] * _N, [4, -1, 4, 4], [5] * _N, [7] * _N])
    with ProcgenVectorEnv("coinrun", _N, **_OPTIONS) as vector:
        expected, _ = vector.reset()
        data = env.reset()
        for each in actions:
            np.testing.assert_array_equal(data["observation"].numpy(), expected)
            data["action"] = torch.from_numpy(each)
            stepped, data = env.step_and_maybe_reset(data)
            last, rewards, terminations, *_ = vector.step(each)
            np.testing.assert_array_equal(stepped["next", "observation"].numpy(), last)
            np.testing.assert_array_equal(stepped["next", "reward"].numpy()[:, 0], rewards)
            assert stepped["next", "terminated"][:, 0].tolist() == terminations.tolist()
            expected = last
            if terminations.any():
                expected, _ = vector.reset(options={"reset_mask": terminations})
    env.close()


def test_vector_environment_has_the_attribute_of_gymnasiums_own() -> None:
    with ProcgenVectorEnv("maze", 1, autoreset_mode="SameStep") as env:
        assert env.autoreset_mode is env.metadata["autoreset_mode"]
