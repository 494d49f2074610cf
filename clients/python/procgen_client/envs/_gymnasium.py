"""Gymnasium's classes and ids, or equal classes where it is not installed or older than 1.1."""

from __future__ import annotations

import enum
from typing import Any

import numpy as np

from procgen_client.envs import _spaces
from procgen_client.options import GAMES

# Namespace of the ids, e.g. "procgen_server/coinrun-v0".
NAMESPACE = "procgen_server"


class _Environment:
    """The common part of gymnasium.Env and gymnasium.vector.VectorEnv."""

    metadata: dict[str, Any] = {}
    spec: Any = None
    render_mode: str | None = None
    _np_random: np.random.Generator | None = None
    _np_random_seed: int | None = None

    def __enter__(self) -> Any:  # noqa: ANN401 - of the subclass's own type
        """Returns the environment itself."""
        return self

    def __exit__(self, *exception: object) -> None:
        """Closes the environment."""
        self.close()

    def close(self, **kwargs: Any) -> None:
        """Releases resources; subclasses override it."""

    @property
    def unwrapped(self) -> Any:  # noqa: ANN401 - of the subclass's own type
        """The environment itself, since it is not a wrapper."""
        return self

    @property
    def np_random(self) -> np.random.Generator:
        """A random generator for wrappers; the environments do not use it."""
        if self._np_random is None:
            self._seed_np_random(None)
        assert self._np_random is not None
        return self._np_random

    @np_random.setter
    def np_random(self, value: np.random.Generator) -> None:
        self._np_random = value
        self._np_random_seed = -1  # Gymnasium's value for an unknown seed.

    @property
    def np_random_seed(self) -> int | None:
        """The seed of that generator."""
        if self._np_random_seed is None:
            self._seed_np_random(None)
        return self._np_random_seed

    def _seed_np_random(self, seed: int | None) -> None:
        sequence = np.random.SeedSequence(seed)
        assert isinstance(sequence.entropy, int)
        self._np_random_seed = sequence.entropy
        self._np_random = np.random.Generator(np.random.PCG64(sequence))


try:
    import gymnasium
    from gymnasium import Env
    from gymnasium.vector.utils import batch_space

    HAS_GYMNASIUM = True
    spaces: Any = gymnasium.spaces
except ImportError:
    HAS_GYMNASIUM = False
    spaces = _spaces

    class Env(_Environment):  # type: ignore[no-redef]
        """The part of gymnasium.Env that is used here."""

        def reset(
            self, *, seed: int | None = None, options: dict[str, Any] | None = None
        ) -> Any:  # noqa: ANN401 - as gymnasium.Env's
            """Seeds np_random if `seed` is not None."""
            if seed is not None:
                self._seed_np_random(seed)

    def batch_space(space: Any, n: int) -> Any:  # noqa: ANN401
        """Returns the space of batches of n, as gymnasium.vector.utils.batch_space."""
        if isinstance(space, _spaces.Discrete):
            return _spaces.MultiDiscrete(np.full(n, space.n))
        return _spaces.Box(0, 255, (n, *space.shape), space.dtype)


try:
    from gymnasium.vector import AutoresetMode, VectorEnv

    HAS_VECTOR_ENV = True
except ImportError:  # Before 1.1 VectorEnv has another contract, and there is no AutoresetMode.
    HAS_VECTOR_ENV = False

    class VectorEnv(_Environment):  # type: ignore[no-redef]
        """The part of gymnasium.vector.VectorEnv that is used here."""

        closed = False
        num_envs: int

        def close(self, **kwargs: Any) -> None:
            """Closes once; further calls do nothing."""
            if self.closed:
                return
            self.close_extras(**kwargs)
            self.closed = True

        def close_extras(self, **kwargs: Any) -> None:
            """Releases resources; subclasses override it."""

    class AutoresetMode(enum.Enum):  # type: ignore[no-redef]
        """When the next episode starts, as gymnasium.vector.AutoresetMode."""

        NEXT_STEP = "NextStep"
        SAME_STEP = "SameStep"
        DISABLED = "Disabled"


def single_spaces(shape: tuple[int, ...], action_count: int) -> dict[str, Any]:
    """Returns the spaces of one environment by their attributes of gymnasium.Env."""
    return {
        "observation_space": spaces.Box(0, 255, shape, np.uint8),
        "action_space": spaces.Discrete(action_count),
    }


def vector_spaces(shape: tuple[int, ...], action_count: int, num_envs: int) -> dict[str, Any]:
    """Returns the four spaces of a vector environment by their attributes."""
    single = single_spaces(shape, action_count)
    batched = {name: batch_space(space, num_envs) for name, space in single.items()}
    return {f"single_{name}": space for name, space in single.items()} | batched


def register_environments() -> None:
    """Registers an environment for each game with Gymnasium, where Gymnasium is installed.

    Also under upstream's ids: ``gymnasium.make("procgen_client:procgen-coinrun-v0")``.
    """
    if not HAS_GYMNASIUM:
        return
    entry_points = {"entry_point": "procgen_client:ProcgenGymEnv"}
    if HAS_VECTOR_ENV:
        entry_points["vector_entry_point"] = "procgen_client:ProcgenVectorEnv"
    for game in GAMES:
        for env_id in (f"{NAMESPACE}/{game}-v0", f"procgen-{game}-v0"):
            gymnasium.register(id=env_id, kwargs={"games": game}, **entry_points)
