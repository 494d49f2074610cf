#!/usr/bin/env python3
"""A learner on its own host: executes a script on a server and writes the trace.

It prints "at N" before it sends request N, for each N of --announce. Before each request of --gates
it also waits for a line on standard input, and observes the pool meanwhile.
"""

from __future__ import annotations

import argparse
import json
import select
import sys
import time
from pathlib import Path

import numpy as np
from learner_script import Script
from learner_trace import Trace, digests_of

from procgen_client import Batch, Client, Pool, Reset

# Longer than any fault.
_RECONNECT_TIMEOUT_S = 300.0
_LEVELS = 1000


class Player:
    """Sends the requests of a script, which do not depend on responses."""

    def __init__(self, script: Script, pool: Pool) -> None:
        """Starts with the script's seed."""
        self._rng = np.random.default_rng(script.seed)
        self._env_count = script.env_count
        self._pool = pool

    def send(self) -> None:
        """Sends the next request."""
        kind = self._rng.integers(100)
        if kind < 3:
            self._pool.send_reset(self._resets(0, self._env_count))
        elif kind < 4:
            self._pool.send_observe()
        elif kind < 20:
            first = int(self._rng.integers(self._env_count))
            self._send_step(first, int(self._rng.integers(1, self._env_count - first + 1)))
        else:
            self._send_step(0, self._env_count)

    def _send_step(self, first: int, count: int) -> None:
        actions = self._rng.integers(0, 15, count)
        actions[self._rng.random(count) < 0.01] = -1
        levels = {}
        if self._rng.integers(10) == 0:
            levels = {first + int(self._rng.integers(count)): int(self._rng.integers(_LEVELS))}
        self._pool.send_step(
            actions,
            first_env=first,
            env_count=count,
            observe=bool(self._rng.integers(20)),
            repeat_count=int(self._rng.integers(1, 4)) if self._rng.integers(10) == 0 else 1,
            final_observations=bool(self._rng.integers(2)),
            next_levels=levels,
            resets=self._resets(first, count) if self._rng.integers(20) == 0 else (),
        )

    def _resets(self, first: int, count: int) -> list[Reset]:
        chosen = self._rng.choice(count, size=1 + count // 8, replace=False)
        return [Reset(first + int(i), level_seed=int(self._rng.integers(_LEVELS))) for i in chosen]


def play(script: Script, pool: Pool, announced: set[int], gates: set[int]) -> Trace:
    """Executes the script; returns the trace."""
    player = Player(script, pool)
    digests: list[list[int]] = []
    durations: list[float] = []
    sent_times: list[float] = []
    received_time = 0.0

    def receive() -> None:
        nonlocal received_time
        batch: Batch = pool.receive()
        now = time.monotonic()
        durations.append(now - max(received_time, sent_times[len(durations)]))
        received_time = now
        digests.append(digests_of(batch))

    for number in range(script.request_count):
        if number in announced:
            print(f"at {number}", flush=True)
        if number in gates:
            while pool.in_flight:
                receive()
            while not select.select([sys.stdin], [], [], 0)[0]:
                pool.observe(observe=False)
            sys.stdin.readline()
        sent_times.append(time.monotonic())
        player.send()
        while pool.in_flight >= script.sent_ahead:
            receive()
    while pool.in_flight:
        receive()
    return Trace(np.array(digests, np.uint32), np.array(durations))


def await_nodes(client: Client, count: int) -> None:
    """Waits until the server lists `count` other nodes."""
    for response in client.watch_nodes():
        if len(response.nodes) > count:
            return


def main() -> None:
    """The program."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--server", required=True, help="HOST:PORT")
    parser.add_argument("--node_count", type=int, default=0, help="nodes that it waits for")
    parser.add_argument("--script", required=True, help="a Script as JSON")
    parser.add_argument("--trace", type=Path, required=True, help="file to write")
    parser.add_argument("--announce", default="[]", help="requests, as JSON")
    parser.add_argument("--gates", default="[]", help="requests, as JSON")
    arguments = parser.parse_args()
    script = Script(**json.loads(arguments.script))
    announced = set(json.loads(arguments.announce))
    gates = set(json.loads(arguments.gates))
    with Client(
        arguments.server, timeout=60.0, reconnect_timeout=_RECONNECT_TIMEOUT_S
    ) as client:
        if arguments.node_count:
            await_nodes(client, arguments.node_count)
        with client.create_pool(
            script.games,
            script.env_count,
            requests_in_flight_max=script.sent_ahead,
            chunk_count=script.chunk_count,
            rand_seed=script.seed,
        ) as pool:
            play(script, pool, announced | gates, gates).save(arguments.trace)


if __name__ == "__main__":
    main()
