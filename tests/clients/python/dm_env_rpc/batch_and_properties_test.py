"""Batched worlds and the properties extension, over gRPC."""

from __future__ import annotations

from typing import Any

import numpy as np
from conftest import Agent, rejected

RUNNING = 1
RGB, LEVEL_SEED = 1, 3
INVALID_ARGUMENT, NOT_FOUND, PERMISSION_DENIED, DATA_LOSS = 3, 5, 7, 15


class TestBatch:
    def test_a_batch_has_a_row_for_each_environment(self, agent: Agent) -> None:
        specs = agent.join(agent.create(env_name=["maze", "coinrun"], num_envs=4, rand_seed=1))
        assert list(specs.actions[1].shape) == [4]
        assert list(specs.actions[1].min.int32s.array) == [-1]
        by_name = {spec.name: spec for spec in specs.observations.values()}
        assert list(by_name["rgb"].shape) == [4, 64, 64, 3]
        for name in ("reward", "first", "terminated", "truncated", "level_seed"):
            assert list(by_name[name].shape) == [4]
        begun = agent.step(observations=[RGB, 9])
        assert begun.state == RUNNING
        assert begun.observations[RGB].shape == (4, 64, 64, 3)
        assert begun.observations[9].all()

    def test_environments_end_and_restart_independently(self, agent: Agent) -> None:
        agent.join(agent.create(env_name="maze", num_envs=3, rand_seed=1))
        agent.step()
        answer = agent.step({1: np.int32([4, -1, 4])}, [9, 10, 11])
        assert answer.state == RUNNING
        np.testing.assert_array_equal(answer.observations[9], [False, True, False])
        np.testing.assert_array_equal(answer.observations[10], [False, True, False])
        assert not answer.observations[11].any()

    def test_single_action_is_broadcast_to_the_given_shape(self, agent: Agent) -> None:
        agent.join(agent.create(env_name="maze", num_envs=3, rand_seed=1))
        agent.step()
        request = agent.protocol.pb2.EnvironmentRequest()
        action = request.step.actions[1]
        action.int32s.array.append(-1)
        action.shape.append(3)
        request.step.requested_observations.append(10)
        agent.send(request)
        terminated = agent.protocol.unpack(agent.receive().step.observations[10])
        np.testing.assert_array_equal(terminated, [True, True, True])

    def test_single_environment_properties_are_indexed(self, agent: Agent) -> None:
        agent.join(agent.create(env_name="maze", num_envs=2, rand_seed=1))
        agent.write("next_level_seed.1", np.int32(12))
        levels = agent.step(observations=[LEVEL_SEED]).observations[LEVEL_SEED]
        assert levels[1] == 12
        saved = agent.read("state.0")
        agent.step({1: np.int32([7, 7])})
        agent.write("state.1", saved)
        np.testing.assert_array_equal(agent.read("level_seed"), [levels[0], levels[0]])
        assert agent.read("level_seed.1") == levels[0]
        assert sorted(agent.list("state")) == ["state.0", "state.1"]
        with rejected(NOT_FOUND, "no property 'state.2'"):
            agent.read("state.2")
        with rejected(PERMISSION_DENIED, "'state' cannot be read"):
            agent.read("state")


class TestProperties:
    def test_properties_are_those_of_the_joined_world(self, agent: Agent) -> None:
        assert agent.list() == {}
        with rejected(NOT_FOUND, "no property 'level_seed'"):
            agent.read("level_seed")

    def test_joining_adds_world_properties(self, joined: Agent) -> None:
        listed = joined.list()
        assert sorted(listed) == ["level_seed", "next_level_seed", "state"]
        state = listed["state"]
        assert (state.is_readable, state.is_writable, state.is_listable) == (True, True, False)
        assert list(state.spec.shape) == [-1]
        assert state.description

    def test_errors_have_the_codes_that_clients_expect(self, joined: Agent) -> None:
        with rejected(NOT_FOUND, "no property 'gravity'"):
            joined.read("gravity")
        with rejected(PERMISSION_DENIED, "'level_seed' cannot be written"):
            joined.write("level_seed", np.int32(1))
        with rejected(PERMISSION_DENIED, "'next_level_seed' cannot be read"):
            joined.read("next_level_seed")
        with rejected(PERMISSION_DENIED, "'state' cannot be listed"):
            joined.list("state")
        with rejected(INVALID_ARGUMENT, "next_level_seed has type FLOAT, allowed: an integer type"):
            joined.write("next_level_seed", np.float32(1))
        with rejected(INVALID_ARGUMENT, r"next_level_seed is 2147483648; it is in \[-2147483648,"):
            joined.write("next_level_seed", 2**31)
        with rejected(DATA_LOSS):
            joined.write("state", np.frombuffer(b"nonsense", np.uint8))

    def test_next_level_seed_is_played_in_the_next_episode(self, joined: Agent) -> None:
        joined.write("next_level_seed", 99)  # A Python integer is sent as INT64.
        assert joined.act(4).observations[LEVEL_SEED] == 99
        joined.write("next_level_seed", np.int32(98))
        assert joined.act(4).observations[LEVEL_SEED] == 99
        joined.reset()
        assert joined.act(4).observations[LEVEL_SEED] == 98

    def test_restored_state_continues_identically(self, agent: Agent) -> None:
        agent.join(agent.create(env_name="coinrun", rand_seed=2))
        agent.act(4)
        for _ in range(20):
            agent.act(7)
        saved = agent.read("state")
        before = [agent.act(action) for action in (7, 8, 8, 7)]
        agent.write("state", saved)
        again = [agent.act(action) for action in (7, 8, 8, 7)]
        for old, new in zip(before, again, strict=True):
            assert old.state == new.state
            for uid, value in old.observations.items():
                np.testing.assert_array_equal(value, new.observations[uid])

    def test_state_written_before_the_first_step_is_observed(self, agents: Any) -> None:
        source, target = agents(), agents()
        for agent in (source, target):
            agent.join(agent.create(env_name="coinrun"))
        source.act(4)
        for _ in range(5):
            shown = source.act(7).observations[RGB]
        target.write("state", source.read("state"))
        begun = target.act(0)
        assert begun.state == RUNNING
        np.testing.assert_array_equal(begun.observations[RGB], shown)
