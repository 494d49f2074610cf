"""gym3's Env and types, or equal classes where gym3 is not installed."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import Any, NamedTuple

import numpy as np

try:
    from gym3 import Env as Gym3Env
    from gym3 import types
except ImportError:

    class Gym3Env:  # type: ignore[no-redef]
        """The part of gym3.Env that is used here."""

        def __init__(self, ob_space: Any, ac_space: Any, num: int) -> None:  # noqa: ANN401
            """Takes the types of observations and actions, and the number of environments."""
            self.ob_space = ob_space
            self.ac_space = ac_space
            self.num = num

    class _Discrete(NamedTuple):
        """The integers in [0, n)."""

        n: int
        dtype_name: str

    class _TensorType(NamedTuple):
        """Arrays of one element type."""

        eltype: _Discrete
        shape: tuple[int, ...]

    class _DictType(dict[str, Any]):
        """Dictionaries of types by name."""

        def __init__(self, **subtypes: Any) -> None:
            """Takes the types."""
            super().__init__(subtypes)

    class types:  # type: ignore[no-redef]  # noqa: N801 - as gym3's module
        """The part of gym3.types that is used here."""

        Discrete = _Discrete
        TensorType = _TensorType
        DictType = _DictType


def to_baselines_vec_env() -> Any:  # noqa: ANN401 - a class, or None
    """Returns gym3's class ToBaselinesVecEnv; None without gym3 or Gym, whose spaces it needs."""
    if find_spec("gym3") is None or find_spec("gym") is None:
        return None
    return import_module("gym3").ToBaselinesVecEnv


def observation_type(shape: tuple[int, ...]) -> Any:  # noqa: ANN401
    """Returns the type of {"rgb": uint8 [*shape]}."""
    pixels = types.TensorType(eltype=types.Discrete(256, dtype_name="uint8"), shape=shape)
    return types.DictType(rgb=pixels)


def action_type(action_count: int) -> Any:  # noqa: ANN401
    """Returns the type of an action."""
    number = types.Discrete(action_count, dtype_name=np.dtype(np.int32).name)
    return types.TensorType(eltype=number, shape=())
