"""OpenEnv's own client plays on the example server."""

from __future__ import annotations

import base64
import io
import json
import re
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("openenv")

from openenv.core.generic_client import GenericEnvClient  # noqa: E402

from procgen_client import ProcgenGymEnv  # noqa: E402

_SERVER = Path(__file__).resolve().parents[4] / "clients/python/examples/openenv_server.py"


@pytest.fixture(scope="module")
def url() -> Iterator[str]:
    """The address of a server of easy mazes, at a port that the system chooses."""
    with subprocess.Popen(
        [sys.executable, _SERVER, "--game=maze", "--mode=easy", "--port=0", "--sessions=2"],
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stderr is not None
        printed = ""
        while (found := re.search(r"running on (http://[\d.:]+)", printed)) is None:
            line = process.stderr.readline()
            assert line, printed
            printed += line
        yield found[1]
        process.terminate()
        process.stderr.read()


def _frame_of(png: str) -> np.ndarray:
    image = pytest.importorskip("PIL.Image")
    return np.asarray(image.open(io.BytesIO(base64.b64decode(png))))


def test_an_episode_equals_one_without_the_server(url: str) -> None:
    with (
        GenericEnvClient(base_url=url).sync() as agent,
        ProcgenGymEnv("maze", distribution_mode="easy") as env,
    ):
        result = agent.reset(level_seed=5)
        frame, infos = env.reset(options={"level_seed": 5})
        assert (infos["level_seed"], result.observation["level_seed"]) == (5, 5)
        for action in (7, 5, 1, 3):
            np.testing.assert_array_equal(_frame_of(result.observation["png"]), frame)
            result = agent.step({"action": action})
            frame, reward, *_ = env.step(action)
            assert (result.reward, result.done) == (reward, False)
        assert agent.state()["step_count"] == 4


def test_sessions_have_environments_of_their_own(url: str) -> None:
    with (
        GenericEnvClient(base_url=url).sync() as one,
        GenericEnvClient(base_url=url).sync() as other,
    ):
        seeds = [agent.reset(seed=7).observation["level_seed"] for agent in (one, other)]
        assert seeds[0] == seeds[1]
        one.step({"action": 7})
        assert (one.state()["step_count"], other.state()["step_count"]) == (1, 0)


def test_the_schema_has_one_required_field(url: str) -> None:
    # verifiers 0.4, v1/tasksets/openenv/taskset.py: a model's reply "7" is then {"action": 7}.
    with urllib.request.urlopen(f"{url}/schema") as response:
        schema = json.load(response)["action"]
    assert schema["required"] == ["action"]
    assert schema["properties"]["action"]["maximum"] == 14


def test_wrong_actions_are_errors(url: str) -> None:
    with GenericEnvClient(base_url=url).sync() as agent:
        agent.reset()
        with pytest.raises(Exception, match="VALIDATION_ERROR"):
            agent.step({"action": 15})
        assert not agent.step({"action": 4}).done
