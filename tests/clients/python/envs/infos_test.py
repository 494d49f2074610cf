"""Infos of environments; gymnasium_test.py compares them with those of SyncVectorEnv."""

from __future__ import annotations

import numpy as np

from procgen_client import ProcgenGymEnv, ProcgenVectorEnv


def test_environment_that_starts_an_episode_has_stepped_no_level() -> None:
    with ProcgenVectorEnv("maze", 2) as env:
        _, infos = env.reset()
        assert set(infos) == {"level_seed", "_level_seed"}
        infos = env.step([-1, 4])[-1]
        assert infos["_prev_level_seed"].tolist() == [True, True]
        infos = env.step([4, 4])[-1]
        assert infos["_prev_level_seed"].tolist() == [False, True]
        assert infos["prev_level_seed"][0] == 0
        env.step([-1, -1])
        assert set(env.step([4, 4])[-1]) == {"level_seed", "_level_seed"}


def test_get_info_is_upstreams() -> None:
    # Upstream, get_info of the gym3 environment; with a render_mode the frame for people, "rgb".
    env = ProcgenGymEnv("maze", render_mode="rgb_array")
    _, before = env.reset()
    inner = env
    while not hasattr(inner, "get_info"):  # As DreamerV3's adapter looks for it.
        inner = inner.env
    (info,) = inner.get_info()
    assert info["level_seed"] == before["level_seed"]
    assert info["rgb"].shape == (512, 512, 3)
    np.testing.assert_array_equal(info["rgb"], env.render())
    env.step(-1)
    env.reset()
    (after,) = env.env.get_info()
    assert after["prev_level_seed"] == before["level_seed"]
    env.close()
