"""What the vector environment takes from Gymnasium, and what serves where there is none."""

from __future__ import annotations

import enum
from typing import Any

try:
    import gymnasium
    from gymnasium.vector import AutoresetMode, VectorEnv
    from gymnasium.vector.utils import batch_space

    HAS_GYMNASIUM = True
except ImportError:
    HAS_GYMNASIUM = False

    class AutoresetMode(enum.Enum):  # type: ignore[no-redef]
        """What follows the step that ends an episode, as gymnasium.vector.AutoresetMode."""

        NEXT_STEP = "NextStep"
        SAME_STEP = "SameStep"
        DISABLED = "Disabled"

    class VectorEnv:  # type: ignore[no-redef]
        """The part of gymnasium.vector.VectorEnv that does not need its spaces."""

        metadata: dict[str, Any] = {}
        spec = None
        render_mode: str | None = None
        closed = False
        num_envs: int

        @property
        def unwrapped(self) -> VectorEnv:
            """The environment itself: nothing wraps it."""
            return self

        def close(self, **kwargs: Any) -> None:
            """Closes once; further calls do nothing."""
            if self.closed:
                return
            self.close_extras(**kwargs)
            self.closed = True

        def close_extras(self, **kwargs: Any) -> None:
            """For subclasses: what is to be done on closing."""


def spaces(shape: tuple[int, ...], action_count: int, num_envs: int) -> dict[str, Any]:
    """Gives a vector environment's four spaces by attribute; all None without Gymnasium."""
    names = ("single_observation_space", "single_action_space", "observation_space", "action_space")
    if not HAS_GYMNASIUM:
        return dict.fromkeys(names)
    import numpy as np

    observation = gymnasium.spaces.Box(0, 255, shape, np.uint8)
    action = gymnasium.spaces.Discrete(action_count)
    batched = (batch_space(observation, num_envs), batch_space(action, num_envs))
    return dict(zip(names, (observation, action, *batched), strict=True))
