#!/usr/bin/env python3
"""A learner on its own host: executes a script on one or several servers and writes the trace.

It prints "at N" before it sends request N, for each N of --announce.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import numpy as np
from learner_script import Player, Script
from learner_trace import Digest, Trace

from procgen_client import Client, Pool


def play(script: Script, pool: Pool, announced: set[int]) -> Trace:
    """Executes the script; returns the trace."""
    player = Player(script, pool)
    digests: list[Digest] = []
    durations: list[float] = []
    sent_times: list[float] = []
    received_time = 0.0

    def on_digest(digest: Digest) -> None:
        nonlocal received_time
        now = time.monotonic()
        durations.append(now - max(received_time, sent_times[len(durations)]))
        received_time = now
        digests.append(digest)

    for number in range(script.request_count):
        if number in announced:
            print(f"at {number}", flush=True)
        sent_times.append(time.monotonic())
        player.play(on_digest)
    player.receive_all(on_digest)
    return Trace(np.array(digests, np.uint32), np.array(durations))


def main() -> None:
    """The program."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--server", required=True, help="HOST:PORT, or several with commas")
    parser.add_argument("--reconnect_timeout", type=float, required=True, help="in seconds")
    parser.add_argument("--script", required=True, help="a Script as JSON")
    parser.add_argument("--trace", type=Path, required=True, help="file to write")
    parser.add_argument("--announce", default="[]", help="requests, as JSON")
    arguments = parser.parse_args()
    script = Script(**json.loads(arguments.script))
    announced = set(json.loads(arguments.announce))
    with Client(
        arguments.server, timeout=60.0, reconnect_timeout=arguments.reconnect_timeout
    ) as client, client.create_pool(
        script.games, script.env_count, rand_seed=script.seed, **script.options
    ) as pool:
        play(script, pool, announced).save(arguments.trace)


if __name__ == "__main__":
    main()
