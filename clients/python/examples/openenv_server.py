#!/usr/bin/env python3
"""Serves a game to agents that speak OpenEnv: one environment for each WebSocket.

pip install openenv
python3 openenv_server.py --game coinrun --mode easy [--server ADDRESS]
"""

import argparse
import base64
import struct
import zlib
from typing import Any, Optional

import numpy as np
import uvicorn
from openenv.core.env_server import Action, Environment, Observation, State, create_fastapi_app
from pydantic import Field

from procgen_client import ProcgenGymEnv


class ProcgenAction(Action):
    """One of upstream's 15 actions: 0 to 8 move (4: none), 9 to 14 are the keys D A W S Q E."""

    action: int = Field(ge=0, le=14)


class ProcgenObservation(Observation):
    """A frame. `reward` and `done` are those of OpenEnv."""

    png: str = Field(description="the frame, RGB, as a base64-encoded PNG")
    level_seed: int
    truncated: bool = Field(default=False, description="the time limit ended the episode")


class ProcgenEnvironment(Environment):
    """One environment, of one session."""

    SUPPORTS_CONCURRENT_SESSIONS = True

    def __init__(self, **options: Any) -> None:
        """Takes the arguments of ProcgenGymEnv."""
        super().__init__()
        self._env = ProcgenGymEnv(**options)
        self._state = State(step_count=0)

    def reset(
        self,
        seed: Optional[int] = None,
        episode_id: Optional[str] = None,
        level_seed: Optional[int] = None,
        **kwargs: Any,
    ) -> ProcgenObservation:
        """Starts an episode: in `level_seed`, or the next of the levels that `seed` chooses."""
        frame, infos = self._env.reset(seed=seed, options={"level_seed": level_seed})
        self._state = State(episode_id=episode_id, step_count=0)
        return ProcgenObservation(png=_png(frame), level_seed=infos["level_seed"])

    def step(
        self, action: ProcgenAction, timeout_s: Optional[float] = None, **kwargs: Any
    ) -> ProcgenObservation:
        """Steps; after the end of an episode, reset must follow."""
        frame, reward, terminated, truncated, infos = self._env.step(action.action)
        self._state.step_count += 1
        return ProcgenObservation(
            png=_png(frame),
            level_seed=infos["level_seed"],
            reward=float(reward),
            done=terminated or truncated,
            truncated=truncated,
        )

    @property
    def state(self) -> State:
        """Episode and number of its steps."""
        return self._state

    def close(self) -> None:
        """Closes the environment."""
        self._env.close()


def _png(frame: np.ndarray) -> str:
    """Encodes a frame uint8 [height, width, 3]."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        check = zlib.crc32(kind + data)
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", check)

    height, width, _ = frame.shape
    rows = np.zeros((height, 1 + width * 3), np.uint8)  # Each begins with its filter, 0: none.
    rows[:, 1:] = frame.reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    parts = [(b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes())), (b"IEND", b"")]
    png = b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*part) for part in parts)
    return base64.b64encode(png).decode()


def main() -> None:
    """Serves until it is interrupted."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--game", default="coinrun")
    parser.add_argument("--mode", default="hard", help="distribution_mode")
    parser.add_argument("--screen-size", type=int, default=64, help="side of a frame, in pixels")
    parser.add_argument("--server", help="address of a Procgen Server; default: this process")
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=8000)
    parser.add_argument("--sessions", type=int, default=64, help="most agents at a time")
    arguments = parser.parse_args()

    def make() -> ProcgenEnvironment:
        return ProcgenEnvironment(
            games=arguments.game,
            distribution_mode=arguments.mode,
            screen_size=arguments.screen_size,
            server=arguments.server,
        )

    app = create_fastapi_app(
        make, ProcgenAction, ProcgenObservation, max_concurrent_envs=arguments.sessions
    )
    uvicorn.run(app, host=arguments.host, port=arguments.port)


if __name__ == "__main__":
    main()
