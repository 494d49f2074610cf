"""What a learner does."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Script:
    """Equal scripts make equal requests: steps of the pool and of slices, resets, chosen levels."""

    seed: int = 1
    request_count: int = 2000
    env_count: int = 16
    games: list[str] = field(default_factory=lambda: ["coinrun", "maze", "starpilot", "jumper"])
    sent_ahead: int = 2  # Requests that may be unanswered.
    chunk_count: int = 2  # Parts that the answer to a step of the whole pool comes in, at least.
