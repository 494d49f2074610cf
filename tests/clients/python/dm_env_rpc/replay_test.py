"""The golden recordings of Procgen 0.10.7 ("upstream"), replayed through dm_env_rpc."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Agent

_GOLDEN = Path(__file__).resolve().parents[3] / "conformance/golden"
# The recordings of four games have every option; the rules of the others are compared elsewhere.
_GAMES = ("bigfish", "coinrun", "maze", "miner")
_RUNNING = 1
# Observations by the arrays of a recording. Those of the episode that was stepped, then the others.
_OUTCOME = {"reward": 2, "prev_level_seed": 4, "prev_level_complete": 5}
_CURRENT = {"level_seed": 3}
_RGB, _FIRST = 1, 9


class Recording:
    """A recording: its options, and its arrays [rows, environments]."""

    def __init__(self, path: Path) -> None:
        line, _, rest = path.read_bytes().partition(b"\n")
        header = json.loads(line)
        self.settings = {name: int(value) if isinstance(value, bool) else value
                         for name, value in header["options"].items()}
        self.settings["env_name"] = self.settings["env_name"].split(",")
        self.env_count: int = header["num_envs"]
        self.arrays: dict[str, np.ndarray] = {}
        for name, dtype, rows in header["arrays"]:
            count = rows * self.env_count
            values = np.frombuffer(rest, "<" + dtype, count)
            self.arrays[name] = values.reshape(rows, self.env_count)
            rest = rest[values.nbytes:]
        self.actions = self.arrays.pop("action").view(np.int8).astype(np.int32)
        options = header["options"]
        is_flat = options["use_monochrome_assets"] and not options["use_backgrounds"]
        if not (is_flat or options["use_generated_assets"]):
            self.arrays.pop("observation_fnv1a", None)  # Drawn with upstream's art.

    def observations(self) -> list[int]:
        """The numbers of the observations to compare."""
        pictures = [_RGB] if "observation_fnv1a" in self.arrays else []
        return [*_OUTCOME.values(), *_CURRENT.values(), *pictures]

    def assert_equal(self, rows: list[dict[str, Any]]) -> None:
        """Compares the bits of all values."""
        for name, expected in self.arrays.items():
            key = "rgb" if name == "observation_fnv1a" else name
            got = np.stack([row[key] for row in rows])
            if key == "rgb":
                got = _digests(got)
            got = got.astype(expected.dtype).view(f"u{expected.itemsize}")
            np.testing.assert_array_equal(got, expected.view(got.dtype), err_msg=name)


def _digests(pictures: np.ndarray) -> np.ndarray:
    """32-bit FNV-1a of each picture of [rows, environments, ...]."""
    octets = np.ascontiguousarray(pictures.reshape(*pictures.shape[:2], -1).transpose(2, 0, 1))
    digests = np.full(pictures.shape[:2], 0x811C9DC5, np.uint32)
    for each in octets:
        digests = (digests ^ each) * np.uint32(16777619)
    return digests


def _row(outcome: dict[int, Any], current: dict[int, Any], first: object) -> dict[str, Any]:
    row = {name: outcome[uid] for name, uid in _OUTCOME.items()}
    row.update({name: current[uid] for name, uid in _CURRENT.items()})
    return {**row, "rgb": current.get(_RGB), "first": first}


@pytest.fixture(
    params=[path for game in _GAMES for path in sorted(_GOLDEN.glob(f"{game}.*.trace"))],
    ids=lambda path: path.stem,
)
def recording(request: pytest.FixtureRequest) -> Recording:
    """Each recording."""
    return Recording(request.param)


# Each recording in both kinds of worlds, and in both places. That these are equal is tested by
# places_test.py.
@pytest.mark.parametrize("address", ["process"], indirect=True)
def test_batched_world_matches_the_recording(agent: Agent, recording: Recording) -> None:
    agent.join(agent.create(**recording.settings, num_envs=recording.env_count))
    wanted = [*recording.observations(), _FIRST]
    steps = [agent.step(observations=wanted)]
    steps += [agent.step({1: actions}, wanted) for actions in recording.actions]
    recording.assert_equal(
        [_row(step.observations, step.observations, step.observations[_FIRST]) for step in steps]
    )


@pytest.mark.parametrize("address", ["server"], indirect=True)
def test_single_environments_match_the_recording(agents: Any, recording: Recording) -> None:
    if (recording.actions == -1).any():
        pytest.skip("a single environment has no action that ends an episode")
    columns = []
    for i in range(recording.env_count):
        columns.append(_play_single(agents(), recording, i))
    rows = [
        {name: np.stack([row[name] for row in across]) for name in across[0]}
        for across in zip(*columns, strict=True)
    ]
    recording.assert_equal(rows)


def _play_single(agent: Agent, recording: Recording, i: int) -> list[dict[str, Any]]:
    """Plays environment i as a world of its own.

    Where a step ends an episode, upstream returns the next one's first observation, for which
    dm_env_rpc needs another step.
    """
    total = recording.env_count
    agent.join(agent.create(**recording.settings, first_env=i, total_env_count=total))
    wanted = recording.observations()
    begun = agent.step(observations=wanted).observations
    rows = [_row(begun, begun, True)]
    for action in recording.actions[:, i]:
        step = agent.step({1: action}, wanted)
        has_ended = step.state != _RUNNING
        after = agent.step(observations=wanted) if has_ended else step
        rows.append(_row(step.observations, after.observations, has_ended))
    return rows
