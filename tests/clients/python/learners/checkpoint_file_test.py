"""Checkpoints of runs keep every value, and loading one executes nothing."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from learners import checkpoint_file


def _saved(path: Path, checkpoint: dict[str, Any]) -> dict[str, Any]:
    with open(path, "wb") as file:
        checkpoint_file.save(file, checkpoint)
    return checkpoint_file.load(path)


def test_values_of_a_checkpoint_are_kept(tmp_path: Path) -> None:
    network = torch.nn.Linear(3, 2)
    optimizer = torch.optim.Adam(network.parameters())
    network(torch.ones(3)).sum().backward()
    optimizer.step()
    random = np.random.default_rng(5)
    plain = {
        "options": {"game": "coinrun", "width": 1.5, "resume": True, "path": None, 7: [1, (2, 3)]},
        "random": random.bit_generator.state,
        "states": [b"", b"\x00\xff snapshot"],
        "limit": float("inf"),
    }
    arrays = {"flags": np.array([True, False]), "sums": np.arange(6.0).reshape(2, 3)}
    learner = {"network": network.state_dict(), "optimizer": optimizer.state_dict()}
    loaded = _saved(tmp_path / "file", {**plain, "arrays": arrays, "learner": learner})
    assert {name: loaded[name] for name in plain} == plain
    for name, array in arrays.items():
        assert loaded["arrays"][name].dtype == array.dtype
        np.testing.assert_array_equal(loaded["arrays"][name], array)
    for name, tensor in network.state_dict().items():
        assert torch.equal(loaded["learner"]["network"][name], tensor)
    again = torch.optim.Adam(network.parameters())
    again.load_state_dict(loaded["learner"]["optimizer"])
    assert torch.equal(again.state_dict()["state"][0]["exp_avg"],
                       optimizer.state_dict()["state"][0]["exp_avg"])  # fmt: skip


def test_values_that_would_need_a_pickle_are_rejected(tmp_path: Path) -> None:
    with pytest.raises(TypeError, match="a checkpoint has a PosixPath"):
        _saved(tmp_path / "file", {"path": tmp_path})


class _Intruder:
    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.path,)


@pytest.mark.parametrize("write", [torch.save, pickle.dump])
def test_loading_executes_nothing(tmp_path: Path, write: Any) -> None:  # noqa: ANN401
    path, touched = tmp_path / "checkpoint.pt", tmp_path / "touched"
    with open(path, "wb") as file:
        write({"options": _Intruder(touched)}, file)
    with pytest.raises(ValueError, match="checkpoint.pt is not a checkpoint of these learners"):
        checkpoint_file.load(path)
    assert not touched.exists()


def test_damaged_checkpoint_is_rejected(tmp_path: Path) -> None:
    path = tmp_path / "checkpoint.pt"
    _saved(path, {"step": 5})
    path.write_bytes(path.read_bytes()[:-50])
    with pytest.raises(ValueError, match="is not a checkpoint"):
        checkpoint_file.load(path)
