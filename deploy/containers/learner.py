#!/usr/bin/env python3
"""Stands in for a learner: steps a pool with random actions and prints the rate."""

from __future__ import annotations

import argparse
import sys
import time

import numpy as np

from procgen_client import ACTION_COUNT, Client, ProcgenError

_SECONDS_BETWEEN_REPORTS = 5.0


def play(client: Client, arguments: argparse.Namespace) -> None:
    """Steps for the given time and prints environment steps per second."""
    rng = np.random.default_rng(0)
    with client.create_pool(arguments.game, arguments.environments) as pool:
        begin = reported = time.monotonic()
        steps = steps_reported = 0
        longest = 0.0
        now = begin
        while not arguments.seconds or now < begin + arguments.seconds:
            pool.step(rng.integers(0, ACTION_COUNT, pool.env_count))
            steps += pool.env_count
            longest = max(longest, time.monotonic() - now)
            now = time.monotonic()
            if now >= reported + _SECONDS_BETWEEN_REPORTS:
                rate = (steps - steps_reported) / (now - reported)
                print(f"{rate:,.0f} steps/s, longest wait {longest * 1000:,.0f} ms", flush=True)
                reported, steps_reported, longest = now, steps, 0.0
        print(f"{steps:,} steps, {steps / (now - begin):,.0f} steps/s", flush=True)


def main() -> int:
    """Runs the program and returns its exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--server",
        default="127.0.0.1:50051",
        help="HOST:PORT or unix:PATH; several separated by commas",
    )
    parser.add_argument("--game", default="coinrun", help="the game")
    parser.add_argument("--environments", type=int, default=256, help="number of environments")
    parser.add_argument("--seconds", type=float, default=0, help="duration; 0: until stopped")
    arguments = parser.parse_args()
    try:
        with Client(arguments.server) as client:
            play(client, arguments)
    except ProcgenError as error:
        print(f"procgen-learner: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
