"""Fixtures: the program procgen-dm-env-rpc, and agents that connect to it with grpcio."""

from __future__ import annotations

import contextlib
import importlib
import os
import queue
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import grpc
import numpy as np
import pytest

_PROTOS = Path(__file__).resolve().parent / "protos"
PROGRAM = (sys.executable, "-m", "procgen_client.dm_env_rpc.server")

# By DataType: the field of Tensor and the type of its elements.
_FIELDS = {
    1: ("floats", np.float32),
    2: ("doubles", np.float64),
    3: ("int8s", np.int8),
    4: ("int32s", np.int32),
    5: ("int64s", np.int64),
    6: ("uint8s", np.uint8),
    7: ("uint32s", np.uint32),
    8: ("uint64s", np.uint64),
    9: ("bools", np.bool_),
}


class RequestError(Exception):
    """The response to a request was an error."""

    def __init__(self, code: int, message: str) -> None:
        super().__init__(f"{code}: {message}")
        self.code = code
        self.message = message


@contextlib.contextmanager
def rejected(code: int, match: str = "") -> Iterator[None]:
    """Expects that the block raises this error."""
    with pytest.raises(RequestError, match=match) as error:
        yield
    assert error.value.code == code


class Protocol:
    """The generated modules, and conversions of tensors."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        subprocess.run(
            [
                "protoc", f"--proto_path={_PROTOS}", f"--python_out={folder}",
                f"--grpc_python_out={folder}",
                f"--plugin=protoc-gen-grpc_python={shutil.which('grpc_python_plugin')}",
                "dm_env_rpc/v1/dm_env_rpc.proto", "dm_env_rpc/v1/extensions/properties.proto",
            ],
            check=True,
        )
        sys.path.insert(0, str(folder))
        self.pb2 = importlib.import_module("dm_env_rpc.v1.dm_env_rpc_pb2")
        self.properties = importlib.import_module("dm_env_rpc.v1.extensions.properties_pb2")
        self.grpc = importlib.import_module("dm_env_rpc.v1.dm_env_rpc_pb2_grpc")

    def pack(self, value: Any) -> Any:  # noqa: ANN401
        """Converts a value to a tensor, with the types that dm_env_rpc's client uses."""
        array = np.asarray(value)
        tensor = self.pb2.Tensor(shape=array.shape)
        if array.dtype.kind == "U":
            tensor.strings.array.extend(array.ravel().tolist())
            return tensor
        for name, dtype in _FIELDS.values():
            if array.dtype == dtype:
                if array.dtype.itemsize == 1 and array.dtype != np.bool_:
                    getattr(tensor, name).array = array.tobytes()
                else:
                    getattr(tensor, name).array.extend(array.ravel().tolist())
        return tensor

    def unpack(self, tensor: Any) -> Any:  # noqa: ANN401
        """Converts a tensor to an array or a scalar."""
        name = tensor.WhichOneof("payload")
        values = getattr(tensor, name).array
        if name == "strings":
            return list(values)
        dtype = next(dtype for field, dtype in _FIELDS.values() if field == name)
        read = np.frombuffer if isinstance(values, bytes) else np.array
        return read(values, dtype).reshape(tensor.shape)[()]


class Agent:
    """A client with one stream."""

    def __init__(self, protocol: Protocol, address: str, metadata: Sequence[Any] = ()) -> None:
        self.protocol = protocol
        self._channel = grpc.insecure_channel(address)
        self._requests: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self.responses = protocol.grpc.EnvironmentStub(self._channel).Process(
            iter(self._requests.get, None), metadata=metadata
        )
        self.specs: Any = None

    def send(self, request: Any) -> None:  # noqa: ANN401
        """Sends a request without waiting for its response."""
        self._requests.put(request)

    def receive(self) -> Any:  # noqa: ANN401
        """Waits for the next response; raises RequestError if it is an error."""
        response = next(self.responses)
        if response.HasField("error"):
            raise RequestError(response.error.code, response.error.message)
        return response

    def ask(self, **payload: Any) -> Any:  # noqa: ANN401
        """Sends a request and returns its response."""
        self.send(self.protocol.pb2.EnvironmentRequest(**payload))
        response = self.receive()
        kind = next(iter(payload))
        assert response.WhichOneof("payload") == kind
        return getattr(response, kind)

    def _settings(self, settings: Mapping[str, Any]) -> dict[str, Any]:
        return {name: self.protocol.pack(value) for name, value in settings.items()}

    def create(self, **settings: Any) -> str:
        """Creates a world and returns its name."""
        request = self.protocol.pb2.CreateWorldRequest(settings=self._settings(settings))
        return self.ask(create_world=request).world_name

    def join(self, world_name: str, **settings: Any) -> Any:  # noqa: ANN401
        """Joins a world and returns its specs."""
        request = self.protocol.pb2.JoinWorldRequest(
            world_name=world_name, settings=self._settings(settings)
        )
        self.specs = self.ask(join_world=request).specs
        return self.specs

    def step(
        self, actions: Mapping[int, Any] | None = None, observations: Sequence[int] = ()
    ) -> SimpleNamespace:
        """Steps; returns the state, and the observations by number."""
        request = self.protocol.pb2.StepRequest(
            actions=self._settings(actions or {}), requested_observations=observations
        )
        response = self.ask(step=request)
        unpack = self.protocol.unpack
        observed = {uid: unpack(tensor) for uid, tensor in response.observations.items()}
        return SimpleNamespace(state=response.state, observations=observed)

    def act(self, action: int) -> SimpleNamespace:
        """Steps with an action; requests all observations."""
        return self.step({1: np.int32(action)}, list(self.specs.observations))

    def reset(self, **settings: Any) -> Any:  # noqa: ANN401
        """Resets and returns the specs."""
        return self.ask(
            reset=self.protocol.pb2.ResetRequest(settings=self._settings(settings))
        ).specs

    def reset_world(self, world_name: str, **settings: Any) -> None:
        """Resets a world."""
        self.ask(
            reset_world=self.protocol.pb2.ResetWorldRequest(
                world_name=world_name, settings=self._settings(settings)
            )
        )

    def leave(self) -> None:
        """Leaves the world."""
        self.ask(leave_world=self.protocol.pb2.LeaveWorldRequest())

    def destroy(self, world_name: str) -> None:
        """Destroys a world."""
        self.ask(destroy_world=self.protocol.pb2.DestroyWorldRequest(world_name=world_name))

    def _property(self, **payload: Any) -> Any:  # noqa: ANN401
        request = self.protocol.pb2.EnvironmentRequest()
        request.extension.Pack(self.protocol.properties.PropertyRequest(**payload))
        self.send(request)
        answer = self.protocol.properties.PropertyResponse()
        assert self.receive().extension.Unpack(answer)
        return answer

    def read(self, key: str) -> Any:  # noqa: ANN401
        """Reads a property."""
        answer = self._property(read_property={"key": key})
        return self.protocol.unpack(answer.read_property.value)

    def write(self, key: str, value: Any) -> None:  # noqa: ANN401
        """Writes a property."""
        self._property(write_property={"key": key, "value": self.protocol.pack(value)})

    def list(self, key: str = "") -> dict[str, Any]:
        """Lists properties by key."""
        answer = self._property(list_property={"key": key})
        return {value.spec.name: value for value in answer.list_property.values}

    def close(self) -> None:
        """Ends the stream, as dm_env_rpc's Connection.close does."""
        self._requests.put(None)
        self.responses.cancel()
        self._channel.close()


@pytest.fixture(scope="session")
def protocol(tmp_path_factory: pytest.TempPathFactory) -> Protocol:
    """The code that protoc generates from the protos beside this file."""
    return Protocol(tmp_path_factory.mktemp("generated"))


@pytest.fixture(scope="session")
def environment(protocol: Protocol) -> dict[str, str]:
    """Variables with which the program finds the generated code, in place of dm-env-rpc."""
    path = os.pathsep.join([str(protocol.folder), os.environ["PYTHONPATH"]])
    return {**os.environ, "PYTHONPATH": path}


@contextlib.contextmanager
def adapter(environment: dict[str, str], *flags: str) -> Iterator[str]:
    """Runs the program; the value is its address. It must end by itself after an interrupt."""
    command = [*PROGRAM, "--address=127.0.0.1:0", *flags]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        try:
            assert "serving worlds of" in line, line
            yield line.split()[-1]
        finally:
            process.send_signal(signal.SIGINT)
            assert process.wait(60) == 0


@pytest.fixture(scope="session", params=["process", "server"])
def address(request: pytest.FixtureRequest, environment: dict[str, str]) -> Iterator[str]:
    """The address of an adapter, for worlds in its own process and for worlds on a server."""
    flags = []
    if request.param == "server":
        flags = [f"--server={request.getfixturevalue('server').address}"]
    with adapter(environment, *flags) as running:
        yield running


@pytest.fixture
def agents(protocol: Protocol, address: str) -> Iterator[Any]:
    """Creates agents and closes them after the test."""
    made: list[Agent] = []

    def make() -> Agent:
        made.append(Agent(protocol, address))
        return made[-1]

    yield make
    for agent in made:
        agent.close()


@pytest.fixture
def agent(agents: Any) -> Agent:  # noqa: ANN401
    """An agent without a world."""
    return agents()


@pytest.fixture
def world(agent: Agent) -> str:
    """A world of one environment with a single level."""
    return agent.create(env_name="maze", distribution_mode="easy", rand_seed=7, num_levels=1)


@pytest.fixture
def joined(agent: Agent, world: str) -> Agent:
    """An agent that has joined the world."""
    agent.join(world)
    return agent
