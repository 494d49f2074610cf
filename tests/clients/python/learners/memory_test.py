"""Agents with a stack of frames or an LSTM learn from what they have acted on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from small_runs import options, train

from learners import policy, ppo
from learners.agent import Agent, AgentPolicy
from learners.environments import Environments, environment_options
from learners.ranks import Ranks
from procgen_client import Pool

_KINDS = ({"frame_stack": 3}, {"lstm": True})


@pytest.mark.parametrize("kind", _KINDS)
def test_first_minibatch_repeats_the_choices_of_the_rollout(kind: dict[str, int]) -> None:
    """Else the ratio of new to old probabilities is not 1; 64 steps end many episodes."""
    parsed = ppo.parse(options(Path(), None, num_steps=64, precision="float32", **kind))
    environments = Environments("bigfish", 8, **environment_options(parsed, 0, 1))
    learner = ppo.Ppo(parsed, Ranks("gloo"), environments)
    for _ in range(2):  # The second rollout continues with the memory of the first.
        assert learner.collector.collect().episodes
        count = len(learner.rollout.actions) // learner.row_count_of_index
        _, metrics = learner.minibatch_gradients(torch.arange(count))
        kl, clipped = metrics[3:].tolist()
        assert abs(kl) < 1e-3
        assert clipped == 0
    environments.close()


@pytest.mark.parametrize("kind", _KINDS)
def test_run_stopped_after_an_update_is_continued(
    tmp_path: Path, kind: dict[str, int]
) -> None:
    short = {"total_steps": 512, **kind}
    expected = train(tmp_path / "uninterrupted", **short)
    train(tmp_path / "stopped", time_limit=0, **short)
    stopped = train(tmp_path / "stopped", resume=True, **short)
    if "lstm" in kind:
        assert stopped == expected
    assert len(stopped["learning"].splitlines()) == 3
    load = policy.load_run(tmp_path / "stopped")
    assert load(np.zeros((2, 64, 64, 3), np.uint8)).shape == (2,)


def test_policy_stacks_frames_as_a_pool_does() -> None:
    agent = Agent(vars(ppo.parse(options(Path(), None, frame_stack=3))))
    player = AgentPolicy(agent)
    with Pool("bigfish", 4, rand_seed=1) as one, Pool(
        "bigfish", 4, rand_seed=1, frame_stack=3
    ) as stacked:
        batch, expected = one.observe(), stacked.observe()
        ended = 0
        for step in range(120):
            assert (player._stacked(batch.observations, batch.first) == expected.observations).all()
            actions = np.full(4, step % 15)
            batch, expected = one.step(actions), stacked.step(actions)
            ended += batch.ended.sum()
    assert ended


def test_memory_is_cleared_where_an_episode_starts() -> None:
    agent = Agent(vars(ppo.parse(options(Path(), None, lstm=True))))
    frames = np.random.default_rng(0).integers(0, 256, (3, 2, 64, 64, 3), np.uint8)
    player = AgentPolicy(agent)
    for frame in frames[:2]:
        player.evaluate(frame)
    known, _ = player.evaluate(frames[2], np.array([False, True]))
    fresh, _ = AgentPolicy(agent).evaluate(frames[2])
    assert torch.equal(known[1], fresh[1])
    assert not torch.equal(known[0], fresh[0])
