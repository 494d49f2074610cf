"""Spaces without Gymnasium print as Gymnasium's."""

from __future__ import annotations

import numpy as np
import pytest

from procgen_client.envs import _spaces

_BOX = _spaces.Box(0, 255, (64, 64, 3), np.uint8)


@pytest.mark.parametrize(
    ("space", "expected"),
    [
        # spaces/box.py, discrete.py, multi_discrete.py, dict.py of Gymnasium 1.4.0: __repr__.
        (_BOX, "Box(0, 255, (64, 64, 3), uint8)"),
        (_spaces.Discrete(15), "Discrete(15)"),
        (_spaces.MultiDiscrete([15, 15, 15]), "MultiDiscrete([15 15 15])"),
        (_spaces.Dict({"rgb": _BOX}), "Dict('rgb': Box(0, 255, (64, 64, 3), uint8))"),
    ],
)
def test_spaces_print_as_those_of_gymnasium(space: _spaces.Space, expected: str) -> None:
    assert repr(space) == expected
    assert str(space) == expected
