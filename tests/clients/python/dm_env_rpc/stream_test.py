"""Streams of dm_env_rpc: invalid messages, their end, and several at once."""

from __future__ import annotations

import threading
from typing import Any

import grpc
import pytest
from conftest import Agent, Protocol, RequestError, rejected

from procgen_client import Client, ServerProcess

RUNNING = 1
INVALID_ARGUMENT = 3
LEVEL_SEED = 3


class TestMessages:
    def test_invalid_messages_get_errors_and_the_stream_continues(
        self, protocol: Protocol, address: str
    ) -> None:
        create = protocol.pb2.EnvironmentRequest()
        create.create_world.settings["env_name"].strings.array.append("maze")
        sent = [b"\x0a\xff\xff", create.SerializeToString(), b"", b"\xff"]
        with grpc.insecure_channel(address) as channel:
            call = channel.stream_stream("/dm_env_rpc.v1.Environment/Process")
            received = [protocol.pb2.EnvironmentResponse.FromString(data)
                        for data in call(iter(sent))]
        assert received[0].error.code == INVALID_ARGUMENT
        name = "dm_env_rpc.v1.EnvironmentRequest"
        assert received[0].error.message == f"the request's 3 bytes are not a valid {name}"
        assert received[1].HasField("create_world")
        assert "is empty, allowed: create_world" in received[2].error.message
        assert "1 bytes are not a valid" in received[3].error.message
        assert len(received) == len(sent)

    def test_invalid_extensions_are_named(self, agent: Agent) -> None:
        extension = agent.protocol.properties.PropertyRequest()
        request = agent.protocol.pb2.EnvironmentRequest()
        request.extension.Pack(extension)
        agent.send(request)
        with rejected(INVALID_ARGUMENT, "PropertyRequest is empty, allowed: read_property"):
            agent.receive()
        request.extension.value = b"\xff\xff"
        agent.send(request)
        with rejected(INVALID_ARGUMENT, "the extension's 2 bytes are not a valid dm_env_rpc"):
            agent.receive()

    def test_a_claimed_shape_takes_no_memory(self, joined: Agent) -> None:
        joined.act(4)
        request = joined.protocol.pb2.EnvironmentRequest()
        action = request.step.actions[1]
        action.int32s.array.append(4)
        action.shape.append(2**31 - 1)
        joined.send(request)
        with rejected(INVALID_ARGUMENT, r"has shape \[2147483647\] and 1 elements"):
            joined.receive()
        assert joined.act(4).state == RUNNING

    @pytest.mark.parametrize("call", ["join", "destroy", "reset_world", "read"])
    def test_errors_cut_long_names(self, agent: Agent, call: str) -> None:
        with pytest.raises(RequestError) as error:
            getattr(agent, call)("\u20ac" * 100_000)
        assert len(error.value.message) < 700
        assert error.value.message.endswith("...")



class TestOthers:
    def test_requests_before_half_close_are_answered(self, agent: Agent, world: str) -> None:
        pb2 = agent.protocol.pb2
        agent.send(pb2.EnvironmentRequest(join_world=pb2.JoinWorldRequest(world_name=world)))
        for _ in range(20):
            agent.send(pb2.EnvironmentRequest(step=pb2.StepRequest()))
        agent.send(None)
        kinds = [response.WhichOneof("payload") for response in agent.responses]
        assert kinds == ["join_world", *["step"] * 20]

    def test_rejoining_within_an_episode_begins_another(self, agent: Agent) -> None:
        world = agent.create(env_name="maze", rand_seed=7)
        agent.join(world)
        first = agent.act(4).observations[LEVEL_SEED]
        agent.leave()
        agent.join(world)
        assert agent.act(4).observations[LEVEL_SEED] == first  # Nothing was stepped.
        agent.act(7)
        agent.leave()
        agent.join(world)
        assert agent.act(4).observations[LEVEL_SEED] != first

    def test_many_agents_play_at_once(self, agents: Any) -> None:
        states: list[int] = []

        def play(agent: Agent) -> None:
            world = agent.create(env_name="maze")
            agent.join(world)
            states.extend(agent.step().state for _ in range(200))
            agent.leave()
            agent.destroy(world)

        threads = [threading.Thread(target=play, args=(agents(),)) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert states == [RUNNING] * 600

    def test_a_world_on_a_server_is_a_pool(
        self, agent: Agent, request: pytest.FixtureRequest, server: ServerProcess
    ) -> None:
        if request.node.callspec.params["address"] != "server":
            pytest.skip("worlds are in the process")
        world = agent.create(env_name="maze", pool_id="seen")
        assert world == "pools/seen"
        agent.join(world)
        agent.step()
        agent.step()
        with Client(server.address) as client:
            # The first step only starts the episode.
            assert client.get_pool(world).step_count == 1
            agent.leave()
            agent.destroy(world)
            assert world not in [pool.name for pool in client.list_pools()]
