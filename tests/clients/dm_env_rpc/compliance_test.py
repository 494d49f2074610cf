"""What clients of dm_env_rpc rely on, with gRPC's Python and code generated from our protos.

The groups are those of the protocol's own compliance tests: worlds, joining, resets, observations
and actions of steps.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import Agent, RequestError, refused

RUNNING, TERMINATED, INTERRUPTED = 1, 2, 3
RGB, REWARD, LEVEL_SEED = 1, 2, 3
INVALID_ARGUMENT, NOT_FOUND, FAILED_PRECONDITION, UNIMPLEMENTED = 3, 5, 9, 12


class TestCreateDestroyWorld:
    def test_worlds_are_made_and_destroyed(self, agent: Agent) -> None:
        agent.destroy(agent.create(env_name="coinrun"))

    def test_settings_must_be_known(self, agent: Agent) -> None:
        with refused(INVALID_ARGUMENT, "no setting 'gravity', allowed: env_name, num_envs"):
            agent.create(env_name="coinrun", gravity=9.81)

    def test_the_name_of_a_game_is_required(self, agent: Agent) -> None:
        with refused(INVALID_ARGUMENT, "settings have no env_name"):
            agent.create(num_levels=3)

    def test_an_unknown_game_is_named_with_those_there_are(self, agent: Agent) -> None:
        with refused(NOT_FOUND, 'no game is named "pong"; there are bigfish'):
            agent.create(env_name="pong")

    @pytest.mark.parametrize("name", ["pools/none-such", "nonsense", ""])
    def test_unknown_worlds_are_not_destroyed(self, agent: Agent, name: str) -> None:
        with pytest.raises(RequestError):
            agent.destroy(name)

    def test_a_joined_world_is_not_destroyed(self, joined: Agent, agents: Any, world: str) -> None:
        with refused(FAILED_PRECONDITION, "joined by this stream"):
            joined.destroy(world)
        with refused(FAILED_PRECONDITION, "joined by another stream"):
            agents().destroy(world)
        assert joined.act(4).state == RUNNING

    @pytest.mark.parametrize("mode", ["easy", 0, np.uint8(0)])
    @pytest.mark.parametrize("seed", [np.int8(3), np.int32(3), 3, np.uint64(3)])
    def test_integers_of_any_type_will_do(self, agent: Agent, mode: Any, seed: Any) -> None:
        name = agent.create(env_name="maze", distribution_mode=mode, rand_seed=seed)
        agent.destroy(name)

    @pytest.mark.parametrize(
        ("settings", "message"),
        [
            ({"num_levels": -1}, "num_levels is -1, allowed: 0 to 2147483647"),
            ({"num_levels": 1.5}, "num_levels has type DOUBLE, allowed: an integer type"),
            ({"num_levels": [1, 2]}, r"num_levels has shape \[2\] and 2 elements, allowed: shape"),
            ({"center_agent": 2}, "center_agent is 2, allowed: 0 to 1"),
            ({"distribution_mode": "hardest"}, "distribution_mode is 'hardest', allowed: 'easy'"),
            ({"distribution_mode": 3}, r"distribution_mode is 3, allowed: 'easy' \(0\)"),
            ({"num_envs": 0}, "num_envs is 0, allowed: 1 to"),
            ({"layout": "cwh"}, "layout is 'cwh', allowed: 'hwc', 'chw'"),
            ({"lease_duration": 0.1}, "lease_duration is 100ms, allowed: 1s"),
        ],
    )
    def test_wrong_values_are_named(
        self, agent: Agent, settings: dict[str, Any], message: str
    ) -> None:
        with refused(INVALID_ARGUMENT, message):
            agent.create(env_name="maze", **settings)


class TestJoinLeaveWorld:
    def test_specs_say_what_the_world_takes_and_tells(self, joined: Agent) -> None:
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
        # The adaptor would return it where the environment's tests want None.
        assert "discount" not in names

    def test_bounds_have_the_type_of_what_they_bound(self, joined: Agent) -> None:
        fields = {4: "int32s", 6: "uint8s"}
        for spec in [*joined.specs.actions.values(), *joined.specs.observations.values()]:
            for bound in (spec.min, spec.max):
                assert bound.WhichOneof("payload") in (None, fields.get(spec.dtype))

    def test_a_second_join_is_an_error(self, joined: Agent, world: str) -> None:
        with refused(FAILED_PRECONDITION, "leave it before another is joined"):
            joined.join(world)
        assert joined.act(4).state == RUNNING

    def test_another_agent_cannot_join(self, joined: Agent, agents: Any, world: str) -> None:
        with refused(FAILED_PRECONDITION, "another stream is attached"):
            agents().join(world)
        assert joined.act(4).state == RUNNING

    def test_a_wrong_world_cannot_be_joined(self, agent: Agent) -> None:
        with refused(NOT_FOUND, "no pool pools/none-such"):
            agent.join("pools/none-such")

    def test_joining_takes_no_settings(self, agent: Agent, world: str) -> None:
        with refused(INVALID_ARGUMENT, "no setting 'seed', allowed: none with join_world"):
            agent.join(world, seed=1)
        agent.join(world)

    def test_leaving_what_was_not_joined_is_fine(self, agent: Agent) -> None:
        agent.leave()
        agent.leave()

    def test_a_world_that_was_left_can_be_joined(
        self, joined: Agent, agents: Any, world: str
    ) -> None:
        joined.act(4)
        joined.leave()
        other = agents()
        other.join(world)
        assert other.act(4).state == RUNNING

    def test_the_end_of_a_stream_leaves(self, joined: Agent, agents: Any, world: str) -> None:
        joined.act(4)
        joined.close()
        other = agents()
        for _ in range(1000):  # The server has to notice.
            try:
                other.join(world)
                break
            except RequestError as error:
                assert error.code == FAILED_PRECONDITION
        assert other.act(4).state == RUNNING

    @pytest.mark.parametrize("call", ["step", "reset"])
    def test_nothing_is_stepped_or_reset_without_joining(self, agent: Agent, call: str) -> None:
        with refused(FAILED_PRECONDITION, "no world is joined"):
            getattr(agent, call)()

    def test_specs_are_the_same_for_whoever_joins(
        self, joined: Agent, agents: Any, world: str
    ) -> None:
        joined.leave()
        assert agents().join(world) == joined.specs


class TestReset:
    def test_specs_are_sent_again(self, joined: Agent) -> None:
        assert joined.reset() == joined.specs
        joined.act(4)
        assert joined.reset() == joined.specs

    def test_what_runs_begins_anew(self, joined: Agent) -> None:
        begun = joined.act(4).observations
        for action in (7, 5, 1, 3):
            joined.act(action)
        joined.reset()
        again = joined.act(0)
        assert again.state == RUNNING
        np.testing.assert_array_equal(again.observations[RGB], begun[RGB])  # There is one level.

    def test_what_does_not_run_stays_as_it_is(self, agent: Agent) -> None:
        name = agent.create(env_name="maze", rand_seed=3)
        agent.join(name)
        first_level = agent.read("level_seed")
        agent.reset()
        agent.reset()
        assert agent.act(4).observations[LEVEL_SEED] == first_level

    def test_a_level_can_be_asked_for(self, joined: Agent) -> None:
        joined.reset(level_seed=321)
        assert joined.act(4).observations[LEVEL_SEED] == 321
        joined.act(4)
        with refused(INVALID_ARGUMENT, "no setting 'level', allowed: level_seed, rand_seed"):
            joined.reset(level=3)
        assert joined.act(4).state == RUNNING

    def test_a_seed_chooses_the_levels_that_follow(self, agent: Agent) -> None:
        agent.join(agent.create(env_name="maze"))

        def levels() -> list[int]:
            agent.reset(rand_seed=5)
            told = [agent.act(4).observations[LEVEL_SEED]]
            for _ in range(3):
                agent.reset()
                told.append(agent.act(4).observations[LEVEL_SEED])
            return told

        first = levels()
        assert levels() == first
        assert len(set(first)) == 4


class TestResetWorld:
    def test_an_unknown_world_is_an_error(self, agent: Agent) -> None:
        with refused(NOT_FOUND):
            agent.reset_world("pools/none-such")

    def test_ones_own_world_begins_anew(self, joined: Agent, world: str) -> None:
        begun = joined.act(4).observations
        joined.act(7)
        joined.reset_world(world)
        np.testing.assert_array_equal(joined.act(7).observations[RGB], begun[RGB])

    def test_a_world_need_not_be_joined(self, agent: Agent) -> None:
        name = agent.create(env_name="maze", rand_seed=3)
        agent.reset_world(name, level_seed=55)
        agent.join(name)
        assert agent.act(4).observations[LEVEL_SEED] == 55

    def test_another_agent_is_interrupted_before_the_answer(
        self, joined: Agent, agents: Any, world: str
    ) -> None:
        joined.act(4)
        other = agents()
        other.send(
            other.protocol.pb2.EnvironmentRequest(
                reset_world=other.protocol.pb2.ResetWorldRequest(
                    world_name=world, settings={"level_seed": other.protocol.pack(77)}
                )
            )
        )
        # When the other one is heard is not known, but it must be in the end.
        while (answer := joined.act(4)).state != INTERRUPTED:
            assert answer.state in (RUNNING, TERMINATED)
        assert other.receive().HasField("reset_world")
        begun = joined.act(4)
        assert (begun.state, begun.observations[LEVEL_SEED]) == (RUNNING, 77)

    def test_who_waits_for_one_that_leaves_is_answered(
        self, joined: Agent, agents: Any, world: str
    ) -> None:
        joined.act(4)
        other = agents()
        request = other.protocol.pb2.EnvironmentRequest()
        request.reset_world.world_name = world
        other.send(request)
        joined.leave()
        assert other.receive().HasField("reset_world")


class TestStepObservations:
    def test_nothing_requested_is_nothing_told(self, joined: Agent) -> None:
        assert joined.step().observations == {}

    def test_what_is_requested_is_told_and_no_more(self, joined: Agent) -> None:
        told = joined.step(observations=[REWARD]).observations
        assert list(told) == [REWARD]

    def test_repetitions_do_no_harm(self, joined: Agent) -> None:
        told = joined.step(observations=[RGB, REWARD, RGB]).observations
        assert sorted(told) == [RGB, REWARD]
        assert told[RGB].shape == (64, 64, 3)

    @pytest.mark.parametrize("uid", [0, 9, 4711, 2**64 - 1])
    def test_unknown_ones_are_named(self, joined: Agent, uid: int) -> None:
        with refused(INVALID_ARGUMENT, f"no observation {uid}, allowed: 1 to 8"):
            joined.step(observations=[RGB, uid])

    def test_unknown_ones_are_found_before_the_step(self, joined: Agent) -> None:
        joined.act(4)
        before = joined.read("state")
        with refused(INVALID_ARGUMENT):
            joined.step({1: np.int32(7)}, [4711])
        np.testing.assert_array_equal(joined.read("state"), before)

    def test_all_are_as_their_specs_say(self, joined: Agent) -> None:
        types = {1: np.float32, 4: np.int32, 6: np.uint8, 8: np.uint64, 9: np.bool_}
        for _ in range(2):
            told = joined.act(4).observations
            for uid, spec in joined.specs.observations.items():
                assert told[uid].dtype == types[spec.dtype], spec.name
                assert told[uid].shape == tuple(spec.shape), spec.name

    def test_the_first_observation_is_worth_nothing(self, joined: Agent) -> None:
        assert joined.act(4).observations[REWARD] == 0


class TestStepActions:
    def test_the_first_step_takes_no_action(self, agents: Any) -> None:
        idle, active = agents(), agents()
        for agent in (idle, active):
            agent.join(agent.create(env_name="coinrun", rand_seed=5))
        np.testing.assert_array_equal(
            idle.step(observations=[RGB]).observations[RGB], active.act(7).observations[RGB]
        )

    @pytest.mark.parametrize("actions", [{4711: 1}, {1: 99}, {1: "up"}, {1: [1, 2]}])
    def test_the_first_step_minds_no_action(self, joined: Agent, actions: dict[int, Any]) -> None:
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
    def test_wrong_actions_move_nothing(
        self, joined: Agent, actions: dict[int, Any], message: str
    ) -> None:
        joined.act(4)
        before = joined.read("state")
        with refused(INVALID_ARGUMENT, message):
            joined.step(actions)
        np.testing.assert_array_equal(joined.read("state"), before)
        assert joined.act(4).state == RUNNING

    def test_actions_left_out_do_nothing(self, joined: Agent, agents: Any) -> None:
        other = agents()
        settings = {"distribution_mode": "easy", "rand_seed": 7, "num_levels": 1}
        other.join(other.create(env_name="maze", **settings))
        joined.act(4)
        other.act(4)
        joined.act(4)
        other.step()
        np.testing.assert_array_equal(joined.read("state"), other.read("state"))

    def test_what_ends_is_terminated_and_begins_with_the_next_step(self, agent: Agent) -> None:
        # An idle fish in bigfish is eaten eventually.
        agent.join(agent.create(env_name="bigfish", rand_seed=1))
        assert agent.act(4).state == RUNNING
        while (answer := agent.act(4)).state == RUNNING:
            pass
        assert answer.state == TERMINATED
        ended = agent.read("state")
        begun = agent.step({4711: 1}, [REWARD, LEVEL_SEED])  # Not even its number is looked at.
        assert (begun.state, begun.observations[REWARD]) == (RUNNING, 0)
        # A state saved between two episodes continues with the next episode.
        agent.write("state", ended)
        again = agent.step({1: np.int32(4)}, [LEVEL_SEED])
        assert (again.state, again.observations[LEVEL_SEED]) == (RUNNING, begun.observations[3])

    def test_a_time_limit_interrupts(self, agent: Agent) -> None:
        agent.join(agent.create(env_name="maze", distribution_mode="easy", rand_seed=7))
        agent.act(4)
        steps = 1
        while (answer := agent.step()).state == RUNNING:
            steps += 1
        assert (answer.state, steps) == (INTERRUPTED, 500)
        assert agent.step().state == RUNNING


class TestStream:
    def test_requests_may_be_sent_ahead(self, agent: Agent, world: str) -> None:
        pb2 = agent.protocol.pb2
        agent.send(pb2.EnvironmentRequest(join_world=pb2.JoinWorldRequest(world_name=world)))
        for _ in range(50):
            agent.send(pb2.EnvironmentRequest(step=pb2.StepRequest(requested_observations=[RGB])))
        agent.send(pb2.EnvironmentRequest(leave_world=pb2.LeaveWorldRequest()))
        kinds = [agent.receive().WhichOneof("payload") for _ in range(52)]
        assert kinds == ["join_world", *["step"] * 50, "leave_world"]

    def test_a_request_for_nothing_is_answered(self, agent: Agent) -> None:
        agent.send(agent.protocol.pb2.EnvironmentRequest())
        with refused(INVALID_ARGUMENT, "is empty, allowed: create_world"):
            agent.receive()

    def test_unknown_extensions_are_answered(self, agent: Agent) -> None:
        request = agent.protocol.pb2.EnvironmentRequest()
        request.extension.Pack(agent.protocol.pb2.Tensor())
        agent.send(request)
        with refused(UNIMPLEMENTED, "offered: dm_env_rpc.v1.extensions.properties.PropertyRequest"):
            agent.receive()
