"""Plays the policy of a finished PPO run: at the pace of a viewer, or as a video.

    python3 -m learners.watch runs/coinrun --server 127.0.0.1:50051
    python3 -m learners.watch runs/coinrun --video coinrun.mp4

The server's pages show the environments, enlarged also with the policy's value and probabilities.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

from learners import cpu
from learners.agent import AgentPolicy
from learners.policy import load_agent
from procgen_client import Batch, Pool, ProcgenError, VideoRecorder


def main(argv: Sequence[str] | None = None) -> None:
    """Steps a pool on all levels until it is interrupted, or the video ends."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("run", type=Path, help="the run's folder")
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--server", help="address of a server with --web_address")
    where.add_argument("--video", metavar="FILE", help="write an mp4 file; needs ffmpeg")
    parser.add_argument("--environments", type=int, default=16, help="default: %(default)s")
    parser.add_argument(
        "--rate", type=float, default=15, help="steps per second; default: %(default)s"
    )
    parser.add_argument("--steps", type=int, default=450, help="of a video; default: %(default)s")
    arguments = parser.parse_args(argv)
    cpu.use_one_thread()
    try:
        agent, options = load_agent(arguments.run)
        with Pool(
            *(options["game"], arguments.environments),
            server=arguments.server,
            distribution_mode=options["mode"],
            use_sequential_levels=options["sequential_levels"],
        ) as pool:
            play = _record if arguments.video else _serve
            play(pool, AgentPolicy(agent), arguments)
    except (ProcgenError, FileNotFoundError) as error:
        parser.error(str(error))


def _serve(pool: Pool, policy: AgentPolicy, arguments: argparse.Namespace) -> None:
    print(f"playing {pool.name}; Ctrl-C ends it", flush=True)
    batch, due = pool.observe(), time.monotonic()
    try:
        while True:
            batch = _step(pool, policy, batch, annotate=True)
            due = max(due + 1 / arguments.rate, time.monotonic() - 1)
            time.sleep(max(0.0, due - time.monotonic()))
    except KeyboardInterrupt:
        pass


def _record(pool: Pool, policy: AgentPolicy, arguments: argparse.Namespace) -> None:
    batch = pool.observe()
    with VideoRecorder(
        pool,
        arguments.video,
        environments=range(pool.env_count),
        size_px=192,
        frames_per_second=round(arguments.rate),
    ) as video:
        for _ in range(arguments.steps):
            video.capture()
            batch = _step(pool, policy, batch, annotate=False)


def _step(pool: Pool, policy: AgentPolicy, batch: Batch, *, annotate: bool) -> Batch:
    log_probabilities, values = policy.evaluate(batch.observations, batch.first)
    annotations = {"value": values, "action_probabilities": log_probabilities.exp()}
    actions = policy.sample(log_probabilities)
    return pool.step(actions, annotations=annotations if annotate else None)


if __name__ == "__main__":
    main()
