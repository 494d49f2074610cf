"""The requests of a learner."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Script:
    """Equal scripts give equal requests: steps of the pool and of slices, resets, next levels."""

    seed: int = 1
    request_count: int = 2000
    env_count: int = 16
    games: list[str] = field(default_factory=lambda: ["coinrun", "maze", "starpilot", "jumper"])
    sent_ahead: int = 2  # Maximum number of requests in flight.
    chunk_count: int = 2  # Minimum number of responses to a step of the whole pool.
