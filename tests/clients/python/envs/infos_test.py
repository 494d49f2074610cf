"""Infos of ProcgenVectorEnv equal those of Gymnasium's SyncVectorEnv of ProcgenGymEnv.

Debian has no Gymnasium. The classes below follow vector/sync_vector_env.py and the method _add_info
of vector/vector_env.py of Gymnasium 1.4.0, as far as infos are concerned. Where Gymnasium is
installed, the test also compares with its own class.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from procgen_client import AutoresetMode, ProcgenGymEnv, ProcgenVectorEnv

_N = 5
_OPTIONS = {"distribution_mode": "easy"}
# With SAME_STEP Gymnasium has them in final_info only.
_ALSO_BESIDE_FINAL_INFO = {"episode_return", "episode_length"}


class _Sync:
    """Steps environments one after the other and collects their infos."""

    def __init__(
        self, makers: list[Callable[[], ProcgenGymEnv]], autoreset_mode: AutoresetMode
    ) -> None:
        self.envs = [make() for make in makers]
        self._mode = autoreset_mode
        self._ended = np.zeros(len(makers), bool)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[None, dict[str, Any]]:
        options = dict(options or {})
        mask = options.pop("reset_mask", np.ones(len(self.envs), bool))
        infos: dict[str, Any] = {}
        for i in np.flatnonzero(mask):
            own = None if seed is None else seed + int(i)
            self._add(infos, self.envs[i].reset(seed=own, options=options)[1], i)
        self._ended[mask] = False
        return None, infos

    def step(self, actions: np.ndarray) -> tuple[Any, ...]:
        infos: dict[str, Any] = {}
        before = self._ended.copy()
        for i, env in enumerate(self.envs):
            if before[i] and self._mode is AutoresetMode.NEXT_STEP:
                info, self._ended[i] = env.reset()[1], False
            else:
                observation, _, terminated, truncated, info = env.step(actions[i])
                self._ended[i] = terminated or truncated
                if self._ended[i] and self._mode is AutoresetMode.SAME_STEP:
                    self._add(infos, {"final_obs": observation, "final_info": info}, i)
                    info = env.reset()[1]
            self._add(infos, info, i)
        return None, None, self._ended.copy(), np.zeros(len(self.envs), bool), infos

    def close(self) -> None:
        for env in self.envs:
            env.close()

    def _add(self, infos: dict[str, Any], info: dict[str, Any], i: int) -> None:
        for key, value in info.items():
            if isinstance(value, dict):
                self._add(infos.setdefault(key, {}), value, i)
            else:
                kind = object if isinstance(value, np.ndarray) else type(value)
                empty = np.full(len(self.envs), None if kind is object else 0, kind)
                infos.setdefault(key, empty)[i] = value
            infos.setdefault(f"_{key}", np.zeros(len(self.envs), bool))[i] = True


def _assert_equal(own: dict[str, Any], theirs: dict[str, Any], may_have: set[str]) -> None:
    surplus = {key.removeprefix("_") for key in own.keys() - theirs.keys()}
    assert theirs.keys() <= own.keys()
    assert surplus <= may_have
    for key, value in theirs.items():
        if isinstance(value, dict):
            _assert_equal(own[key], value, set())
            continue
        assert own[key].dtype == value.dtype, key
        if value.dtype == object:  # Frames, or None.
            for left, right in zip(own[key], value, strict=True):
                np.testing.assert_array_equal(left, right, err_msg=key)
        else:
            np.testing.assert_array_equal(own[key], value, err_msg=key)


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize("library", ["brief", "gymnasium"])
def test_infos_equal_those_of_a_sync_vector_env(mode: AutoresetMode, library: str) -> None:
    sync_class = _Sync
    if library == "gymnasium":
        sync_class = pytest.importorskip("gymnasium", minversion="1.1").vector.SyncVectorEnv
    makers = [lambda: ProcgenGymEnv("bigfish", **_OPTIONS)] * _N
    sync = sync_class(makers, autoreset_mode=mode)
    own = ProcgenVectorEnv("bigfish", _N, autoreset_mode=mode, **_OPTIONS)
    may_have = _ALSO_BESIDE_FINAL_INFO if mode is AutoresetMode.SAME_STEP else set()
    _assert_equal(own.reset(seed=3)[1], sync.reset(seed=3)[1], set())
    rng, end_count = np.random.default_rng(0), 0
    for _ in range(150):
        actions = rng.integers(0, 15, _N)
        # -1 is outside of the action space, but SyncVectorEnv passes it to the environments.
        actions[rng.random(_N) < 0.05] = -1
        step, theirs = own.step(actions), sync.step(actions)
        ended = step[2] | step[3]
        np.testing.assert_array_equal(ended, theirs[2] | theirs[3])
        _assert_equal(step[-1], theirs[-1], may_have)
        end_count += np.count_nonzero(ended)
        if mode is AutoresetMode.DISABLED and ended.any():
            # SyncVectorEnv removes reset_mask from its options.
            options = [{"reset_mask": ended, "level_seed": 9} for _ in range(2)]
            _assert_equal(
                own.reset(options=options[0])[1], sync.reset(options=options[1])[1], set()
            )
    assert end_count > 20
    own.close()
    sync.close()


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
