"""Watching pools, and reading their episodes."""

from __future__ import annotations

import numpy as np
import pytest

from procgen_client import Client
from procgen_client._proto import render_pb2
from procgen_client.errors import (
    FailedPreconditionError,
    InvalidArgumentError,
    NotFoundError,
)


def test_pool_is_watched_while_it_is_stepped(client: Client) -> None:
    with client.create_pool("maze", 4, rand_seed=3, distribution_mode="easy") as pool:
        frame_sets = client.watch(pool.name, [3, 0], size_px=64, frames_per_second_max=60)
        assert [frame.shape for frame in next(frame_sets)] == [(64, 64, 3)] * 2
        batch = pool.step([7, 4, 5, 1])
        frames = next(frame_sets)
        assert np.array_equal(frames[0], batch.observations[3])
        assert np.array_equal(frames[1], batch.observations[0])
        frame_sets.close()
        assert next(client.watch(pool))[0].shape == (256, 256, 3)


def test_slow_watcher_skips_frame_sets(client: Client) -> None:
    with client.create_pool("bigfish", 1) as pool:
        options = {"size_px": 64, "frames_per_second_max": 60}
        slow, quick = (client.watch(pool, [0], **options) for _ in range(2))
        next(slow)
        next(quick)
        for _ in range(20):
            last = pool.step([4])
            next(quick)
        frame_sets = 1
        while not np.array_equal(next(slow)[0], last.observations[0]):
            frame_sets += 1
        assert frame_sets < 10, f"{frame_sets} frame sets of 20 were queued"


def test_annotations_reach_watchers(client: Client) -> None:
    with client.create_pool("maze", 3, rand_seed=1) as pool:
        request = render_pb2.WatchPoolRequest(
            pool=pool.name, environments=[1], size_px=64, with_steps=True
        )
        responses = client._watch("WatchPool", request, render_pb2.WatchPoolResponse)
        next(responses)
        values = np.array([0.5, -1.5, 2])
        probabilities = np.arange(45, dtype=np.float32).reshape(3, 15)
        pool.step(
            [7, 4, 5], annotations={"value": values, "action_probabilities": probabilities}
        )
        (frame,) = next(responses).frames
        shown = {each.name: list(each.values) for each in frame.step.annotations}
        assert shown == {"value": [-1.5], "action_probabilities": probabilities[1].tolist()}
        pool.step([7, 4, 5])
        assert not next(responses).frames[0].step.annotations


def test_invalid_annotations_are_rejected_and_change_nothing(client: Client) -> None:
    with client.create_pool("maze", 3, rand_seed=1) as pool:
        for values in ([1, 2], [[[1]] * 3], ["a", "b", "c"], 1.0):
            with pytest.raises(InvalidArgumentError, match="one number, or one row of numbers"):
                pool.step([7, 4, 5], annotations={"value": values})
        with pytest.raises(InvalidArgumentError, match="is no array"):
            pool.step([7, 4, 5], annotations={"value": [[1], [2, 3], [4]]})
        assert pool.step([7, 4, 5]).episode_lengths.tolist() == [1, 1, 1]
        with pytest.raises(InvalidArgumentError, match=r"annotations\[0\].name is '' of 0 bytes"):
            pool.step([7, 4, 5], annotations={"": [1, 2, 3]})
        assert pool.step([7, 4, 5]).episode_lengths.tolist() == [2, 2, 2]


def test_frames_beyond_the_default_message_size_are_received(client: Client) -> None:
    with client.create_pool("maze", 16, rand_seed=1) as pool:
        assert len(next(client.watch(pool, size_px=512))) == 16


def test_watch_ends_with_an_error(client: Client) -> None:
    with client.create_pool("maze", 1, rand_seed=1) as pool:
        with pytest.raises(InvalidArgumentError, match="environments"):
            next(client.watch(pool, [1]))
        with pytest.raises(InvalidArgumentError, match="frames_per_second_max"):
            next(client.watch(pool, frames_per_second_max=61))
    with pytest.raises(NotFoundError):
        next(client.watch(pool))


def test_episode_is_found_and_replayed(client: Client) -> None:
    with client.create_pool("coinrun", 2, rand_seed=1) as pool:
        with pytest.raises(FailedPreconditionError, match="ended no episode"):
            client.get_episode(pool, 1)
        batches = [pool.step([4, action]) for action in (7, 8, 7, -1)]
        rewards = [batch.rewards[1] for batch in batches]
        episode = client.get_episode(pool, 1)
        assert list(episode.actions) == [7, 8, 7, 255]
        assert list(episode.rewards) == rewards
        assert list(client.get_episode(pool, 0, "current").actions) == [4] * 4
        with pytest.raises(InvalidArgumentError, match="current"):
            client.get_episode(pool, 0, "next")
        pool.step([4, -1])
        found = client.find_episode(pool, 1, batches[-1].fingerprints[1])
        assert (found.actions, found.fingerprint) == (episode.actions, episode.fingerprint)
        with pytest.raises(NotFoundError):
            client.find_episode(pool, 0, batches[-1].fingerprints[1])
        with pytest.raises(InvalidArgumentError, match="fingerprint is 0"):
            client.find_episode(pool, 1, 0)
    with client.create_pool(
        episode.game, 1, start_level=episode.level_seed, num_levels=1
    ) as again:
        for action, reward in zip([7, 8, 7, -1], rewards, strict=True):
            batch = again.step([action])
            assert batch.rewards[0] == reward
        assert batch.fingerprints[0] == np.uint64(episode.fingerprint & (2**64 - 1))


def test_pools_report_statistics(client: Client) -> None:
    with client.create_pool("maze", 2, rand_seed=1) as pool:
        pool.step([7, -1])
        message = next(each for each in client.list_pools() if each.name == pool.name)
        assert message.episode_count == 1
        assert message.mean_episode_length == 1
        assert message.request_count == 1
        assert message.request_duration_p99.ToTimedelta() == message.request_duration.ToTimedelta()
