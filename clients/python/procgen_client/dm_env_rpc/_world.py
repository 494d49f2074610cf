"""A world: the protocol's states over a pool."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from dm_env_rpc.v1 import dm_env_rpc_pb2 as pb2

from procgen_client._requests import ACTION_COUNT, ACTION_MIN, Reset
from procgen_client.dm_env_rpc import _tensors
from procgen_client.dm_env_rpc._settings import episode_settings
from procgen_client.errors import InvalidArgumentError
from procgen_client.pool import Pool

_ACTION = 1
_NO_MOVE = 4
_RGB = 1
# Names of observations, numbered from 1, and their arrays of a Batch.
_OBSERVATIONS = {
    "rgb": "observations",
    "reward": "rewards",
    "level_seed": "level_seeds",
    "prev_level_seed": "prev_level_seeds",
    "prev_level_complete": "prev_level_complete",
    "episode_return": "episode_returns",
    "episode_length": "episode_lengths",
    "fingerprint": "fingerprints",
}
_OF_BATCHES = {name: name for name in ("first", "terminated", "truncated")}


class World:
    """A pool with a name. Without num_envs it is one environment, else a batch.

    Threads: one at a time, of the stream that has joined it.
    """

    def __init__(self, name: str, pool: Pool) -> None:
        """Owns the pool."""
        self.name, self.pool = name, pool
        self.session: object = None  # The stream that has joined it.
        self._is_single = pool.autoreset_mode == "disabled"
        # Length of a list with a value for each environment; None: such values are scalars.
        self.length = None if self._is_single else pool.env_count
        self._action_min = 0 if self._is_single else ACTION_MIN
        names = _OBSERVATIONS if self._is_single else _OBSERVATIONS | _OF_BATCHES
        self._observations = dict(enumerate(names.items(), start=1))
        self._is_running = False
        # Of the next episodes, by environment.
        self._level_seeds: dict[int, int] = {}
        self._rand_seeds: dict[int, int] = {}
        self._resets_all = False
        self._restored: set[int] = set()  # Environments whose restored state is observed next.
        self._batch = pool.observe(observe=False)

    def join(self) -> Any:  # noqa: ANN401 - a message
        """Has the next step begin episodes; returns the specs."""
        self._is_running = False
        return self.specs()

    def specs(self) -> Any:  # noqa: ANN401 - a message
        """Returns the specs of action and observations."""
        specs = pb2.ActionObservationSpecs()
        rows = [] if self.length is None else [self.length]
        action = specs.actions[_ACTION]
        action.name, action.dtype = "action", _tensors.data_type(np.int32)
        action.shape.extend(rows)
        action.min.int32s.array.append(self._action_min)
        action.max.int32s.array.append(ACTION_COUNT - 1)
        for number, (name, array) in self._observations.items():
            spec = specs.observations[number]
            is_rgb = number == _RGB
            dtype = np.uint8 if is_rgb else getattr(self._batch, array).dtype
            spec.name, spec.dtype = name, _tensors.data_type(dtype)
            spec.shape.extend([*rows, *(self.pool.observation_shape if is_rgb else ())])
        rgb = specs.observations[_RGB]
        rgb.min.uint8s.array, rgb.max.uint8s.array = b"\x00", b"\xff"
        return specs

    def step(self, request: Any, response: Any) -> None:  # noqa: ANN401 - messages
        """Steps, or begins episodes; fills a StepResponse."""
        requested = set(request.requested_observations)
        for number in requested.difference(self._observations):
            raise InvalidArgumentError(
                f"there is no observation {number}, allowed: 1 to {max(self._observations)}"
            )
        response.state = pb2.RUNNING
        if self._is_running:
            self._batch = self.pool.step(
                self._actions(request.actions),
                next_levels=self._level_seeds,
                observe=_RGB in requested,
            )
            if self._is_single and self._batch.ended[0]:
                response.state = pb2.TERMINATED if self._batch.terminated[0] else pb2.INTERRUPTED
        else:
            self._begin(_RGB in requested)
        self._is_running = response.state == pb2.RUNNING
        self._level_seeds, self._rand_seeds, self._restored = {}, {}, set()
        self._resets_all = False
        for number in requested:
            values = getattr(self._batch, self._observations[number][1])
            _tensors.pack(values[0] if self._is_single else values, response.observations[number])

    def reset(self, settings: Mapping[str, Any]) -> None:
        """Has the next step begin episodes. No effect if it does so anyway and without settings."""
        level_seeds, rand_seeds = episode_settings(settings, self.length)
        self._level_seeds |= level_seeds
        self._rand_seeds |= rand_seeds
        self._resets_all |= self._is_running
        self._is_running = False

    def level_seeds(self) -> np.ndarray:
        """Returns the current levels."""
        return self._batch.level_seeds

    def set_next_levels(self, level_seeds: Mapping[int, int]) -> None:
        """Chooses levels of the next episodes, by environment."""
        self._level_seeds |= level_seeds

    def restore(self, environment: int, state: bytes) -> None:
        """Restores an environment. A state from an episode's end continues with the next one."""
        self.pool.restore_states({environment: state})
        self._batch = self.pool.observe(observe=False)
        self._level_seeds.pop(environment, None)
        self._rand_seeds.pop(environment, None)
        self._restored.discard(environment)
        if self._batch.ended[environment] and not self._batch.first[environment]:
            self._is_running = False
        else:
            self._restored.add(environment)

    def _begin(self, observe: bool) -> None:
        """Begins episodes where the environments do not show the first step of one."""
        begun = [first or i in self._restored for i, first in enumerate(self._batch.first.tolist())]
        levels, seeds = self._level_seeds, self._rand_seeds
        resets = [
            Reset(i, levels.get(i), seeds.get(i))
            for i in range(self.pool.env_count)
            if self._resets_all or i in levels or i in seeds or not begun[i]
        ]
        if resets:
            self._batch = self.pool.reset(resets, observe=observe)
        else:
            self._batch = self.pool.observe(observe=observe)
        # Nothing was stepped.
        for array in (self._batch.rewards, self._batch.terminated, self._batch.truncated):
            array[:] = 0

    def _actions(self, given: Mapping[int, Any]) -> np.ndarray:
        for number in given:
            if number != _ACTION:
                raise InvalidArgumentError(f"there is no action {number}, allowed: {_ACTION}")
        count = self.pool.env_count
        if _ACTION not in given:
            return np.full(count, _NO_MOVE, np.int32)
        name = f"action {_ACTION}"
        values = _tensors.unpack(name, given[_ACTION], _tensors.INT32, self.length)
        actions = np.array(values, np.int32).reshape(count)
        for i in np.flatnonzero((actions < self._action_min) | (actions >= ACTION_COUNT))[:1]:
            where = "" if self._is_single else f" for environment {i}"
            raise InvalidArgumentError(
                f"{name} is {actions[i]}{where}, allowed: {self._action_min} to {ACTION_COUNT - 1}"
            )
        return actions
