"""Plays the policy of a finished PPO run at the pace of a viewer.

    python3 -m learners.watch runs/coinrun --server 127.0.0.1:50051

The server's pages show the environments, enlarged also with the policy's value and probabilities.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

import procgen_client
from learners import cpu
from learners.agent import AgentPolicy
from learners.policy import load_agent


def main(argv: Sequence[str] | None = None) -> None:
    """Steps a pool until it is interrupted."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("run", type=Path, help="the run's folder")
    parser.add_argument("--server", required=True, help="address of a server with --web_address")
    parser.add_argument("--environments", type=int, default=16, help="default: %(default)s")
    parser.add_argument(
        "--rate", type=float, default=15, help="steps per second; default: %(default)s"
    )
    arguments = parser.parse_args(argv)
    cpu.use_one_thread()
    try:
        agent, options = load_agent(arguments.run)
    except procgen_client.ProcgenError as error:
        parser.error(error.message)
    policy = AgentPolicy(agent)
    with procgen_client.connect(arguments.server) as client, client.create_pool(
        options["game"], arguments.environments, distribution_mode=options["mode"]
    ) as pool:
        print(f"playing {options['game']} as {pool.name}; Ctrl-C ends it", flush=True)
        batch = pool.observe()
        due = time.monotonic()
        try:
            while True:
                log_probabilities, values = policy.evaluate(batch.observations, batch.first)
                annotations = {"value": values, "action_probabilities": log_probabilities.exp()}
                batch = pool.step(policy.sample(log_probabilities), annotations=annotations)
                due = max(due + 1 / arguments.rate, time.monotonic() - 1)
                time.sleep(max(0.0, due - time.monotonic()))
        except KeyboardInterrupt:
            pass


if __name__ == "__main__":
    main()
