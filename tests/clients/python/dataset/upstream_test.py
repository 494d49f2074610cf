"""Data sets that Procgen 0.10.7 recorded are expanded to equal frames, rewards and levels."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from small_recordings import Frames

from procgen_client import Pool
from procgen_client.dataset import from_actions, replay

_SHARED = Path(__file__).resolve().parents[5] / "shared"
_ART = _SHARED / "released-art"
_RECORDINGS = [
    pytest.param(path, id=path.stem, marks=() if ".easy.options" in path.name else pytest.mark.slow)
    for path in sorted((_SHARED / "reference/pixels").glob("*.trace"))
]


def _read(path: Path) -> tuple[dict, dict[str, np.ndarray]]:
    """The header of a recording, and its arrays, [N, rows]."""
    data = path.read_bytes()
    end = data.index(b"\n")
    header = json.loads(data[:end])
    arrays, begin = {}, end + 1
    for name, dtype, rows in header["arrays"]:
        count = rows * header["num_envs"]
        arrays[name] = np.frombuffer(data, f"<{dtype}", count, begin).reshape(rows, -1).T
        begin += arrays[name].nbytes
    assert begin == len(data)
    return header, arrays


def _fnv1a(frames: np.ndarray) -> np.ndarray:
    """32-bit FNV-1a of each frame, uint32 [N, T]."""
    columns = np.ascontiguousarray(frames.reshape(*frames.shape[:2], -1).transpose(2, 0, 1))
    found = np.full(frames.shape[:2], 0x811C9DC5, np.uint32)
    for column in columns:
        found = (found ^ column) * np.uint32(0x01000193)
    return found


@pytest.fixture(scope="module")
def _loaded_art() -> Iterator[None]:
    """Keeps the art in memory, which pools share."""
    with Pool("maze", 1, art=_ART):
        yield


@pytest.mark.usefixtures("_loaded_art")
@pytest.mark.skipif(not _RECORDINGS, reason="there are no recordings of upstream")
@pytest.mark.parametrize("path", _RECORDINGS)
def test_recording_is_expanded_equal(path: Path) -> None:
    header, recorded = _read(path)
    options = {**header["options"]}
    game = options.pop("env_name")
    art = _ART if not options["use_generated_assets"] else None
    trajectories = from_actions(
        game, recorded["action"].astype(np.int8), art=art, rewards=recorded["reward"][:, 1:],
        **options,
    )  # fmt: skip
    np.testing.assert_array_equal(trajectories.level_seeds, recorded["level_seed"])
    np.testing.assert_array_equal(trajectories.first, recorded["first"])
    frames = Frames()
    replay(trajectories, path.name, art=art, writer=frames)
    np.testing.assert_array_equal(_fnv1a(frames.all), recorded["observation_fnv1a"])
