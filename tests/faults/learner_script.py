"""The requests of a learner, and the class that sends them."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from learner_trace import Digest, digest_of

from procgen_client import Batch, LevelSampler, Pool, Reset, errors

_LEVELS = 1000


@dataclass(frozen=True)
class Script:
    """Equal scripts give equal requests.

    They are steps, resets and observations of the pool and of slices, with next levels; and calls:
    states that are saved, restored and cloned, level samplers, frames, a rejected request.
    """

    seed: int = 1
    request_count: int = 2000
    env_count: int = 16
    games: list[str] = field(default_factory=lambda: ["coinrun", "maze", "starpilot", "jumper"])
    sent_ahead: int = 2  # Maximum number of requests in flight; 1 with autoreset_mode "disabled".
    options: dict[str, Any] = field(default_factory=dict)  # Of the pool, beside rand_seed.


class Player:
    """Sends the requests of a script.

    Only with autoreset_mode "disabled" do they depend on responses: ended episodes are reset.
    """

    def __init__(self, script: Script, pool: Pool) -> None:
        """Starts with the script's seed."""
        self._rng = np.random.default_rng(script.seed)
        self._script = script
        self._pool = pool
        self._ended = np.zeros(script.env_count, np.bool_)  # Episodes that need a reset.
        self._in_flight: deque[slice] = deque()
        self._saved: dict[int, bytes] = {}  # By environment.

    def play(self, on_digest: Callable[[Digest], None]) -> None:
        """Sends the next request, and receives responses while too many are in flight."""
        kind = int(self._rng.integers(100))
        if kind < 3:
            self.receive_all(on_digest)
            on_digest(self._call())
            return
        if kind < 6:
            self._send(0, self._script.env_count, self._pool.send_reset, self._resets())
        elif kind < 8:
            self._send(0, self._script.env_count, self._pool.send_observe)
        elif kind < 24:
            first = int(self._rng.integers(self._script.env_count))
            self._send_step(first, int(self._rng.integers(1, self._script.env_count - first + 1)))
        else:
            self._send_step(0, self._script.env_count)
        while self._pool.in_flight >= self._script.sent_ahead:
            on_digest(self._receive())

    def receive_all(self, on_digest: Callable[[Digest], None]) -> None:
        """Receives the responses in flight."""
        while self._pool.in_flight:
            on_digest(self._receive())

    def _receive(self) -> Digest:
        batch = self._pool.receive()
        self._ended[self._in_flight.popleft()] = batch.ended
        return digest_of(batch)

    def _send(
        self, first: int, count: int, send: Callable[..., None], *arguments: object, **more: object
    ) -> None:
        send(*arguments, first_env=first, env_count=count, **more)
        self._in_flight.append(slice(first, first + count))

    def _send_step(self, first: int, count: int) -> None:
        actions = self._rng.integers(0, 15, count)
        actions[self._rng.random(count) < 0.01] = -1
        levels = {}
        if self._rng.integers(10) == 0:
            levels = {first + int(self._rng.integers(count)): int(self._rng.integers(_LEVELS))}
        resets = self._resets(first, count) if self._rng.integers(20) == 0 else []
        if self._script.options.get("autoreset_mode") == "disabled":
            named = {reset.environment for reset in resets}
            ended = first + np.flatnonzero(self._ended[first : first + count])
            resets += [Reset(int(i)) for i in ended if i not in named]
        self._send(
            first,
            count,
            self._pool.send_step,
            actions,
            observe=bool(self._rng.integers(20)),
            repeat_count=int(self._rng.integers(1, 4)) if self._rng.integers(10) == 0 else 1,
            final_observations=bool(self._rng.integers(2)),
            next_levels=levels,
            resets=resets,
        )

    def _resets(self, first: int = 0, count: int | None = None) -> list[Reset]:
        number = self._script.env_count if count is None else count
        chosen = self._rng.choice(number, size=1 + number // 8, replace=False)
        return [Reset(first + int(i), level_seed=int(self._rng.integers(_LEVELS))) for i in chosen]

    def _call(self) -> Digest:
        """Makes a call while nothing is in flight; the digest is of all that it changes."""
        kind = int(self._rng.integers(7))
        if kind < 2 or not self._saved:
            return self._save()
        if kind == 2:
            environment = int(self._rng.integers(self._script.env_count))
            return digest_of(frames=self._pool.render([environment], size_px=48))
        rejection = ""
        if kind == 3:
            self._restore()
        elif kind == 4:
            self._clone()
        elif kind == 5:
            seeds = self._rng.integers(0, _LEVELS, 20)
            weights = self._rng.integers(1, 10, 20)
            self._pool.set_level_sampler(LevelSampler(seeds, weights, rand_seed=len(self._saved)))
        else:
            rejection = self._restore_damaged()
        batch: Batch = self._pool.observe()
        self._ended[:] = batch.ended
        return digest_of(batch, rejection=rejection)

    def _save(self) -> Digest:
        count = int(self._rng.integers(1, self._script.env_count + 1))
        chosen = self._rng.choice(self._script.env_count, size=count, replace=False).tolist()
        states = self._pool.save_states(chosen)
        self._saved.update(zip(chosen, states, strict=True))
        return digest_of(states=states)

    def _restore(self) -> None:
        """Restores states, also in other environments of the same games."""
        chosen = self._rng.choice(sorted(self._saved), size=1 + len(self._saved) // 4)
        self._pool.restore_states({self._twin(int(i)): self._saved[int(i)] for i in chosen})

    def _clone(self) -> None:
        count = 1 + self._script.env_count // 4
        targets = self._rng.choice(self._script.env_count, size=count, replace=False).tolist()
        self._pool.clone_states([(self._twin(target), target) for target in targets])

    def _restore_damaged(self) -> str:
        """Returns the kind of the error; its message counts environments from the slice's first."""
        environment = int(self._rng.choice(sorted(self._saved)))
        state = bytearray(self._saved[environment])
        state[len(state) // 2] ^= 1
        try:
            self._pool.restore_states({environment: bytes(state)})
        except errors.ProcgenError as error:
            return type(error).__name__
        return "none"

    def _twin(self, environment: int) -> int:
        """An environment of the same game."""
        games = len(self._script.games)
        rows = (self._script.env_count - environment % games + games - 1) // games
        return environment % games + games * int(self._rng.integers(rows))
