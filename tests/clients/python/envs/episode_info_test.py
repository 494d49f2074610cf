"""`record_episode_statistics` adds the info of Gymnasium's RecordEpisodeStatistics.

Source: wrappers/vector/common.py and wrappers/common.py of Gymnasium 1.4.0, which is not needed
here: infos["episode"] has arrays "r", "l" and "t", zero where no episode ended; the mask is
infos["_episode"]. Of a single environment they are numbers.
"""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from procgen_client import AutoresetMode, ProcgenGymEnv, ProcgenVectorEnv

_N = 4


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_ended_episodes_have_return_length_and_time(mode: AutoresetMode) -> None:
    env = ProcgenVectorEnv(
        *("bigfish", _N),
        autoreset_mode=mode,
        distribution_mode="easy",
        record_episode_statistics=True,
    )
    with env:
        begun = np.full(_N, time.perf_counter())  # Of each environment's episode, at the latest.
        env.reset()
        returns, lengths = np.zeros(_N), np.zeros(_N, np.int64)
        pending = np.zeros(_N, bool)  # Their next step starts an episode.
        for t in range(60):
            actions = np.where(np.arange(_N) * 5 == t % 20, -1, 7)
            before = time.perf_counter()
            _, rewards, terminations, truncations, infos = env.step(actions)
            after = time.perf_counter()
            if mode is AutoresetMode.NEXT_STEP:
                begun[pending] = before
            returns, lengths = returns + rewards, lengths + ~pending
            ended = terminations | truncations
            if ended.any():
                episode = infos["episode"]
                np.testing.assert_array_equal(infos["_episode"], ended)
                np.testing.assert_array_equal(episode["r"], np.where(ended, returns, 0))
                np.testing.assert_array_equal(episode["l"], np.where(ended, lengths, 0))
                assert {name: array.dtype for name, array in episode.items()} == {
                    "r": np.float64,
                    "l": np.int64,
                    "t": np.float64,
                }
                assert not episode["t"][~ended].any()
                assert (episode["t"][ended] > 0).all()
                assert (episode["t"][ended] <= (after - begun)[ended]).all()
            else:
                assert "episode" not in infos
            returns[ended], lengths[ended], begun[ended] = 0, 0, before
            if mode is AutoresetMode.NEXT_STEP:
                pending = ended
            elif mode is AutoresetMode.DISABLED and ended.any():
                env.reset(options={"reset_mask": ended})


def test_time_counts_from_the_start_of_the_episode() -> None:
    env = ProcgenVectorEnv("maze", 2, record_episode_statistics=True)
    with env:
        env.reset()
        time.sleep(0.2)
        _, _, _, _, infos = env.step([-1, 4])
        assert infos["episode"]["t"][0] >= 0.2
        env.step([4, 4])  # Environment 0 starts its next episode.
        _, _, _, _, infos = env.step([4, -1])
        assert infos["episode"]["t"].tolist() == [0, infos["episode"]["t"][1]]
        assert infos["episode"]["t"][1] >= 0.2


def test_loaded_episodes_are_counted_from_their_start(tmp_path: Path) -> None:
    env = ProcgenVectorEnv("maze", 1, record_episode_statistics=True)
    with env:
        env.reset()
        for _ in range(3):
            env.step([4])
        env.save(tmp_path / "checkpoint")
        env.reset()
        env.load(tmp_path / "checkpoint")
        infos = env.step([-1])[-1]
        assert infos["episode"]["l"].tolist() == [4]


def test_infos_of_a_single_environment_are_numbers() -> None:
    with ProcgenGymEnv("maze", record_episode_statistics=True) as env:
        env.reset()
        assert "episode" not in env.step(4)[-1]
        infos = env.step(-1)[-1]
        assert infos["episode"]["l"] == 2
        assert [type(value) for value in infos["episode"].values()] == [float, int, float]
