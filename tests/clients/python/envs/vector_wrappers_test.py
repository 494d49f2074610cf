"""What Gymnasium's wrappers of vector environments expect, each with its source.

Sources are modules of Gymnasium 1.4.0, which is not needed here.
"""

from __future__ import annotations

import numpy as np

from procgen_client import AutoresetMode, ProcgenVectorEnv

_N = 4


class _RecordsEpisodes:
    """As wrappers/vector/common.py, RecordEpisodeStatistics, counts steps."""

    def __init__(self, env: ProcgenVectorEnv) -> None:
        self.env = env
        self.lengths = np.zeros(env.num_envs, np.int64)

    def reset(self, options: dict | None = None) -> None:
        self.env.reset(options=options)
        if options is not None and "reset_mask" in options:  # Pops it, after the environment.
            self.lengths[options.pop("reset_mask")] = 0
        else:
            self.lengths[:] = 0


def test_reset_does_not_remove_the_reset_mask() -> None:
    # wrappers/vector/common.py, RecordEpisodeStatistics.reset: looks for options["reset_mask"]
    # after it has reset the environment.
    env = ProcgenVectorEnv("coinrun", _N, autoreset_mode=AutoresetMode.DISABLED)
    wrapped = _RecordsEpisodes(env)
    wrapped.reset()
    for step in range(40):
        actions = np.where(np.arange(_N) == step % _N, -1, 4)
        _, _, terminations, truncations, infos = env.step(actions)
        wrapped.lengths += 1
        ended = terminations | truncations
        np.testing.assert_array_equal(wrapped.lengths * ended, infos["episode_length"])
        wrapped.reset({"reset_mask": ended})
    env.close()


def test_infos_do_not_use_the_key_of_record_episode_statistics() -> None:
    # wrappers/vector/common.py, RecordEpisodeStatistics: rejects infos that have "episode" already.
    with ProcgenVectorEnv("coinrun", _N) as env:
        env.reset()
        _, _, _, _, infos = env.step(np.full(_N, -1))
        assert "episode" not in infos
        assert "_episode" not in infos
