"""Playing actions again gives equal frames, rewards, ends and levels."""

from __future__ import annotations

import dataclasses
import zlib
from typing import Any

import numpy as np
import pytest
from small_recordings import OPTIONS, Frames, small_trajectories

from procgen_client import Pool, errors
from procgen_client.dataset import Trajectories, from_actions, play, replay
from procgen_client.options import GAMES


def _stepped(trajectories: Trajectories, **options: Any) -> dict[str, np.ndarray]:
    """What a pool gives for the actions, by its own loop."""
    header = trajectories.header
    found: dict[str, list[np.ndarray]] = {}
    with Pool(header.game, header.env_count, **header.options, **options) as pool:
        batch = pool.observe()
        found["observations"] = [batch.observations]
        found["level_seeds"] = [batch.level_seeds]
        for actions in trajectories.actions.T.astype(int):
            batch = pool.step(actions)
            for name in ("observations", "rewards", "terminated", "truncated", "level_seeds",
                         "prev_level_complete"):  # fmt: skip
                found.setdefault(name, []).append(getattr(batch, name))
    return {name: np.stack(rows, axis=1) for name, rows in found.items()}


@pytest.mark.parametrize("game", GAMES)
def test_replay_equals_a_pool(game: str) -> None:
    trajectories = small_trajectories(game, 3, 200)
    expected = _stepped(trajectories)
    frames = Frames()
    replay(trajectories, game, writer=frames)
    np.testing.assert_array_equal(frames.all, expected.pop("observations"))
    for name, array in expected.items():
        np.testing.assert_array_equal(getattr(trajectories, name), array, err_msg=name)


def test_digests_are_of_frames() -> None:
    trajectories = small_trajectories(digest_interval=30)
    frames = _stepped(trajectories)["observations"]
    digests = [zlib.crc32(np.ascontiguousarray(frames[:, t])) for t in (0, 30, 60, 90)]
    assert trajectories.frame_digests.tolist() == digests


def test_drawn_frames_may_be_larger() -> None:
    trajectories = small_trajectories()
    frames = Frames()
    replay(trajectories, "", drawing={"screen_size": 32, "grayscale_obs": True}, writer=frames)
    expected = _stepped(trajectories, screen_size=32, grayscale_obs=True)["observations"]
    np.testing.assert_array_equal(frames.all, expected)


def test_slices_of_a_set_are_those_of_the_whole() -> None:
    whole = small_trajectories(env_count=4)
    header = dataclasses.replace(whole.header, env_count=2, first_env=1, total_env_count=4)
    part = play(header, whole.actions[1:3])
    np.testing.assert_array_equal(part.level_seeds, whole.level_seeds[1:3])
    np.testing.assert_array_equal(part.rewards, whole.rewards[1:3])


def test_wrong_frames_and_rewards_are_found() -> None:
    trajectories = small_trajectories()
    other = dataclasses.replace(
        trajectories.header, options={**trajectories.header.options, "use_backgrounds": False}
    )
    with pytest.raises(errors.DataLossError, match="frames at step 0 differ"):
        replay(dataclasses.replace(trajectories, header=other), "x")
    actions = trajectories.actions.copy()
    actions[1, 50] = -1
    with pytest.raises(errors.DataLossError, match="x: .* of environment 1 at step 5"):
        replay(dataclasses.replace(trajectories, actions=actions), "x")


def test_wrong_arguments_are_errors() -> None:
    actions = np.zeros((2, 5), int)
    for wrong, message in (
        (actions + 15, "actions contains 15; actions are -1 ... 14"),
        (actions - 2, "actions contains -2"),
        (actions + 256, "actions contains 256"),
        (actions + 0.5, "type float64; it has one integer"),
        (actions[0], r"actions has shape \[5\]; it is \[environments, steps\]"),
    ):
        with pytest.raises(errors.InvalidArgumentError, match=message):
            from_actions("maze", wrong, rand_seed=1)
    with pytest.raises(errors.InvalidArgumentError, match="rand_seed is missing"):
        from_actions("maze", actions)
    with pytest.raises(errors.InvalidArgumentError, match="trajectories has no option 'frame_st"):
        from_actions("maze", actions, rand_seed=1, frame_stack=4)
    with pytest.raises(errors.NotFoundError):
        from_actions("pong", actions, rand_seed=1)


def test_other_rewards_are_an_error() -> None:
    trajectories = small_trajectories()
    arguments = ("bigfish", trajectories.actions)
    from_actions(*arguments, rewards=trajectories.rewards, rand_seed=3, **OPTIONS)
    wrong = trajectories.rewards.copy()
    wrong[1, 7] = 5
    with pytest.raises(errors.InvalidArgumentError, match="environment 1 at step 7 is 5.0, but"):
        from_actions(*arguments, rewards=wrong, rand_seed=3, **OPTIONS)
    with pytest.raises(errors.InvalidArgumentError, match=r"rewards has shape \[1, 100\]"):
        from_actions(*arguments, rewards=wrong[:1], rand_seed=3, **OPTIONS)


def test_variables_do_not_change_a_replay(monkeypatch: pytest.MonkeyPatch) -> None:
    trajectories = small_trajectories()
    monkeypatch.setenv("PROCGEN_ART", "/none")
    with pytest.raises(errors.FailedPreconditionError, match="PROCGEN_ART is /none: unset it"):
        replay(trajectories, "")
    monkeypatch.delenv("PROCGEN_ART")
    monkeypatch.setenv("PROCGEN_SERVER", "localhost:1")
    with pytest.raises(errors.FailedPreconditionError, match="PROCGEN_SERVER is localhost:1, but"):
        replay(trajectories, "")
