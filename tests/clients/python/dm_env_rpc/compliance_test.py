"""Compliance with dm_env_rpc, tested with grpcio and code generated from its protos.

The classes follow dm_env_rpc's own compliance tests: worlds, joining, resets, observations and
actions of steps.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import Agent, RequestError, rejected

RUNNING, TERMINATED, INTERRUPTED = 1, 2, 3
RGB, REWARD, LEVEL_SEED = 1, 2, 3
INVALID_ARGUMENT, NOT_FOUND, FAILED_PRECONDITION, UNIMPLEMENTED = 3, 5, 9, 12


class TestCreateDestroyWorld:
    def test_worlds_are_created_and_destroyed(self, agent: Agent) -> None:
        agent.destroy(agent.create(env_name="coinrun"))

    def test_unknown_settings_are_rejected(self, agent: Agent) -> None:
        expected = "create_world has no option 'gravity'; its options are center_agent"
        with rejected(INVALID_ARGUMENT, expected):
            agent.create(env_name="coinrun", gravity=9.81)

    def test_env_name_is_required(self, agent: Agent) -> None:
        with rejected(INVALID_ARGUMENT, "settings have no env_name"):
            agent.create(num_levels=3)

    def test_unknown_game_error_lists_the_games(self, agent: Agent) -> None:
        with rejected(NOT_FOUND, 'no game is named "pong"; there are bigfish'):
            agent.create(env_name="pong")

    @pytest.mark.parametrize("name", ["pools/none-such", "nonsense", ""])
    def test_destroying_an_unknown_world_is_an_error(self, agent: Agent, name: str) -> None:
        with pytest.raises(RequestError):
            agent.destroy(name)

    def test_joined_world_cannot_be_destroyed(self, joined: Agent, agents: Any, world: str) -> None:
        with rejected(FAILED_PRECONDITION, "joined by this stream"):
            joined.destroy(world)
        with rejected(FAILED_PRECONDITION, "joined by another stream"):
            agents().destroy(world)
        assert joined.act(4).state == RUNNING

    @pytest.mark.parametrize("mode", ["easy", 0, np.uint8(0)])
    @pytest.mark.parametrize("seed", [np.int8(3), np.int32(3), 3, np.uint64(3)])
    def test_settings_accept_any_integer_type(self, agent: Agent, mode: Any, seed: Any) -> None:
        name = agent.create(env_name="maze", distribution_mode=mode, rand_seed=seed)
        agent.destroy(name)

    @pytest.mark.parametrize(
        ("settings", "message"),
        [
            ({"num_levels": -1}, r"num_levels is -1; it is in \[0, 2147483647\]"),
            ({"num_levels": 1.5}, "num_levels is 1.5; it is an integer in"),
            ({"num_levels": [1, 2]}, r"num_levels is \[1, 2\]; it is an integer in"),
            ({"num_levels": [[1]]}, r"num_levels has shape \[1, 1\] and 1 elements"),
            ({"center_agent": 2}, "center_agent is 2; it is True or False"),
            ({"distribution_mode": "hardest"}, "distribution_mode is 'hardest'; it is one of easy"),
            ({"distribution_mode": 3}, "distribution_mode is 3; it is one of easy"),
            ({"num_envs": 0}, r"num_envs is 0; it is in \[1, 65536\]"),
            ({"layout": "cwh"}, "layout is 'cwh'; it is one of hwc, chw"),
            ({"first_env": 4, "total_env_count": 4}, "total_env_count is 4"),
        ],
    )
    def test_invalid_values_are_named(
        self, agent: Agent, settings: dict[str, Any], message: str
    ) -> None:
        with rejected(INVALID_ARGUMENT, message):
            agent.create(env_name="maze", **settings)


class TestJoinLeaveWorld:
    def test_specs_describe_actions_and_observations(self, joined: Agent) -> None:
        action = joined.specs.actions[1]
        assert (action.name, action.dtype, list(action.shape)) == ("action", 4, [])
        assert list(action.min.int32s.array) == [0]
        assert list(action.max.int32s.array) == [14]
        rgb = joined.specs.observations[RGB]
        assert (rgb.name, rgb.dtype, list(rgb.shape)) == ("rgb", 6, [64, 64, 3])
        assert (rgb.min.uint8s.array, rgb.max.uint8s.array) == (b"\x00", b"\xff")
        reward = joined.specs.observations[REWARD]
        assert (reward.name, reward.dtype, list(reward.shape)) == ("reward", 1, [])
        names = [spec.name for spec in joined.specs.observations.values()]
        assert len(set(names)) == len(names)
        # The dm_env adaptor would return it where dm_env's tests require None.
        assert "discount" not in names

    def test_bounds_have_the_type_of_their_spec(self, joined: Agent) -> None:
        fields = {4: "int32s", 6: "uint8s"}
        for spec in [*joined.specs.actions.values(), *joined.specs.observations.values()]:
            for bound in (spec.min, spec.max):
                assert bound.WhichOneof("payload") in (None, fields.get(spec.dtype))

    def test_second_join_is_an_error(self, joined: Agent, world: str) -> None:
        with rejected(FAILED_PRECONDITION, "leave it before another is joined"):
            joined.join(world)
        assert joined.act(4).state == RUNNING

    def test_occupied_world_cannot_be_joined(self, joined: Agent, agents: Any, world: str) -> None:
        with rejected(FAILED_PRECONDITION, "joined by another stream"):
            agents().join(world)
        assert joined.act(4).state == RUNNING

    def test_unknown_world_cannot_be_joined(self, agent: Agent) -> None:
        with rejected(NOT_FOUND, "no world pools/none-such"):
            agent.join("pools/none-such")

    def test_join_rejects_settings(self, agent: Agent, world: str) -> None:
        with rejected(INVALID_ARGUMENT, "join_world has no option 'seed'; it has none"):
            agent.join(world, seed=1)
        agent.join(world)

    def test_leaving_without_a_world_is_allowed(self, agent: Agent) -> None:
        agent.leave()
        agent.leave()

    def test_left_world_can_be_joined(
        self, joined: Agent, agents: Any, world: str
    ) -> None:
        joined.act(4)
        joined.leave()
        other = agents()
        other.join(world)
        assert other.act(4).state == RUNNING

    def test_ended_stream_leaves_its_world(self, joined: Agent, agents: Any, world: str) -> None:
        joined.act(4)
        joined.close()
        other = agents()
        for _ in range(1000):  # Until the server detects the closed stream.
            try:
                other.join(world)
                break
            except RequestError as error:
                assert error.code == FAILED_PRECONDITION
        assert other.act(4).state == RUNNING

    @pytest.mark.parametrize("call", ["step", "reset"])
    def test_step_and_reset_require_a_joined_world(self, agent: Agent, call: str) -> None:
        with rejected(FAILED_PRECONDITION, "no world is joined"):
            getattr(agent, call)()

    def test_every_agent_receives_the_same_specs(
        self, joined: Agent, agents: Any, world: str
    ) -> None:
        joined.leave()
        assert agents().join(world) == joined.specs


class TestReset:
    def test_reset_returns_the_specs(self, joined: Agent) -> None:
        assert joined.reset() == joined.specs
        joined.act(4)
        assert joined.reset() == joined.specs

    def test_reset_restarts_a_running_episode(self, joined: Agent) -> None:
        begun = joined.act(4).observations
        for action in (7, 5, 1, 3):
            joined.act(action)
        joined.reset()
        again = joined.act(0)
        assert again.state == RUNNING
        np.testing.assert_array_equal(again.observations[RGB], begun[RGB])  # A single level.

    def test_reset_before_the_first_step_keeps_the_level(self, agent: Agent) -> None:
        name = agent.create(env_name="maze", rand_seed=3)
        agent.join(name)
        first_level = agent.read("level_seed")
        agent.reset()
        agent.reset()
        assert agent.act(4).observations[LEVEL_SEED] == first_level

    def test_reset_accepts_a_level_seed(self, joined: Agent) -> None:
        joined.reset(level_seed=321)
        assert joined.act(4).observations[LEVEL_SEED] == 321
        joined.act(4)
        with rejected(INVALID_ARGUMENT, "a reset has no option 'level'"):
            joined.reset(level=3)
        assert joined.act(4).state == RUNNING

    def test_rand_seed_repeats_the_levels(self, agent: Agent) -> None:
        agent.join(agent.create(env_name="maze"))

        def levels() -> list[int]:
            agent.reset(rand_seed=5)
            seeds = [agent.act(4).observations[LEVEL_SEED]]
            for _ in range(3):
                agent.reset()
                seeds.append(agent.act(4).observations[LEVEL_SEED])
            return seeds

        first = levels()
        assert levels() == first
        assert len(set(first)) == 4


class TestResetWorld:
    def test_unknown_world_is_an_error(self, agent: Agent) -> None:
        with rejected(NOT_FOUND):
            agent.reset_world("pools/none-such")

    def test_joined_world_restarts(self, joined: Agent, world: str) -> None:
        begun = joined.act(4).observations
        joined.act(7)
        joined.reset_world(world)
        np.testing.assert_array_equal(joined.act(7).observations[RGB], begun[RGB])

    def test_world_need_not_be_joined(self, agent: Agent) -> None:
        name = agent.create(env_name="maze", rand_seed=3)
        agent.reset_world(name, level_seed=55)
        agent.join(name)
        assert agent.act(4).observations[LEVEL_SEED] == 55

    def test_world_of_another_stream_is_not_reset(
        self, joined: Agent, agents: Any, world: str
    ) -> None:
        joined.act(4)
        with rejected(FAILED_PRECONDITION, "joined by another stream and cannot be reset"):
            agents().reset_world(world)
        assert joined.act(4).state == RUNNING


class TestStepObservations:
    def test_no_requested_observations_returns_none(self, joined: Agent) -> None:
        assert joined.step().observations == {}

    def test_only_requested_observations_are_returned(self, joined: Agent) -> None:
        observations = joined.step(observations=[REWARD]).observations
        assert list(observations) == [REWARD]

    def test_repeated_observations_are_allowed(self, joined: Agent) -> None:
        observations = joined.step(observations=[RGB, REWARD, RGB]).observations
        assert sorted(observations) == [RGB, REWARD]
        assert observations[RGB].shape == (64, 64, 3)

    @pytest.mark.parametrize("uid", [0, 9, 4711, 2**64 - 1])
    def test_unknown_observations_are_named(self, joined: Agent, uid: int) -> None:
        with rejected(INVALID_ARGUMENT, f"no observation {uid}, allowed: 1 to 8"):
            joined.step(observations=[RGB, uid])

    def test_unknown_observations_are_rejected_before_the_step(self, joined: Agent) -> None:
        joined.act(4)
        before = joined.read("state")
        with rejected(INVALID_ARGUMENT):
            joined.step({1: np.int32(7)}, [4711])
        np.testing.assert_array_equal(joined.read("state"), before)

    def test_observations_match_their_specs(self, joined: Agent) -> None:
        types = {1: np.float32, 4: np.int32, 6: np.uint8, 8: np.uint64, 9: np.bool_}
        for _ in range(2):
            observations = joined.act(4).observations
            for uid, spec in joined.specs.observations.items():
                assert observations[uid].dtype == types[spec.dtype], spec.name
                assert observations[uid].shape == tuple(spec.shape), spec.name

    def test_first_reward_is_zero(self, joined: Agent) -> None:
        assert joined.act(4).observations[REWARD] == 0


class TestStepActions:
    def test_first_step_ignores_the_action(self, agents: Any) -> None:
        idle, active = agents(), agents()
        for agent in (idle, active):
            agent.join(agent.create(env_name="coinrun", rand_seed=5))
        np.testing.assert_array_equal(
            idle.step(observations=[RGB]).observations[RGB], active.act(7).observations[RGB]
        )

    @pytest.mark.parametrize("actions", [{4711: 1}, {1: 99}, {1: "up"}, {1: [1, 2]}])
    def test_first_step_does_not_validate_actions(
        self, joined: Agent, actions: dict[int, Any]
    ) -> None:
        assert joined.step(actions).state == RUNNING

    @pytest.mark.parametrize(
        ("actions", "message"),
        [
            ({4711: np.int32(1)}, "no action 4711, allowed: 1"),
            ({1: 1}, "action 1 has type INT64, allowed: INT32"),
            ({1: np.float32(1)}, "action 1 has type FLOAT, allowed: INT32"),
            ({1: "up"}, "action 1 has type STRING, allowed: INT32"),
            ({1: np.int32([1])}, r"action 1 has shape \[1\] and 1 elements, allowed: shape \[\]"),
            ({1: np.int32([[1]])}, r"action 1 has shape \[1, 1\] and 1 elements"),
            ({1: np.int32(15)}, "action 1 is 15, allowed: 0 to 14"),
            ({1: np.int32(-1)}, "action 1 is -1, allowed: 0 to 14"),
        ],
    )
    def test_invalid_actions_change_nothing(
        self, joined: Agent, actions: dict[int, Any], message: str
    ) -> None:
        joined.act(4)
        before = joined.read("state")
        with rejected(INVALID_ARGUMENT, message):
            joined.step(actions)
        np.testing.assert_array_equal(joined.read("state"), before)
        assert joined.act(4).state == RUNNING

    def test_missing_action_is_the_default_action(self, joined: Agent, agents: Any) -> None:
        other = agents()
        settings = {"distribution_mode": "easy", "rand_seed": 7, "num_levels": 1}
        other.join(other.create(env_name="maze", **settings))
        joined.act(4)
        other.act(4)
        joined.act(4)
        other.step()
        np.testing.assert_array_equal(joined.read("state"), other.read("state"))

    def test_ended_episode_is_terminated_and_restarts_in_the_next_step(self, agent: Agent) -> None:
        # An idle fish in bigfish is eaten eventually.
        agent.join(agent.create(env_name="bigfish", rand_seed=1))
        assert agent.act(4).state == RUNNING
        while (answer := agent.act(4)).state == RUNNING:
            pass
        assert answer.state == TERMINATED
        ended = agent.read("state")
        begun = agent.step({4711: 1}, [REWARD, LEVEL_SEED])  # Ignores even unknown actions.
        assert (begun.state, begun.observations[REWARD]) == (RUNNING, 0)
        # A state saved between two episodes continues with the next episode.
        agent.write("state", ended)
        again = agent.step({1: np.int32(4)}, [LEVEL_SEED])
        assert (again.state, again.observations[LEVEL_SEED]) == (RUNNING, begun.observations[3])

    def test_time_limit_interrupts(self, agent: Agent) -> None:
        agent.join(agent.create(env_name="maze", distribution_mode="easy", rand_seed=7))
        agent.act(4)
        steps = 1
        while (answer := agent.step()).state == RUNNING:
            steps += 1
        assert (answer.state, steps) == (INTERRUPTED, 500)
        assert agent.step().state == RUNNING


class TestStream:
    def test_requests_can_be_pipelined(self, agent: Agent, world: str) -> None:
        pb2 = agent.protocol.pb2
        agent.send(pb2.EnvironmentRequest(join_world=pb2.JoinWorldRequest(world_name=world)))
        for _ in range(50):
            agent.send(pb2.EnvironmentRequest(step=pb2.StepRequest(requested_observations=[RGB])))
        agent.send(pb2.EnvironmentRequest(leave_world=pb2.LeaveWorldRequest()))
        kinds = [agent.receive().WhichOneof("payload") for _ in range(52)]
        assert kinds == ["join_world", *["step"] * 50, "leave_world"]

    def test_empty_request_gets_an_error(self, agent: Agent) -> None:
        agent.send(agent.protocol.pb2.EnvironmentRequest())
        with rejected(INVALID_ARGUMENT, "is empty, allowed: create_world"):
            agent.receive()

    def test_unknown_extension_gets_an_error(self, agent: Agent) -> None:
        request = agent.protocol.pb2.EnvironmentRequest()
        request.extension.Pack(agent.protocol.pb2.Tensor())
        agent.send(request)
        offered = "dm_env_rpc.v1.extensions.properties.PropertyRequest"
        with rejected(UNIMPLEMENTED, f"offered: {offered}"):
            agent.receive()
