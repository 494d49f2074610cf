#!/usr/bin/env python3
"""Searches for a high return by branching from saved states.

Each round restores one state in all environments of a pool and tries random moves in each. The next
round starts from the best resulting state: the highest return, and among equal returns one whose
episode has not ended.

    PYTHONPATH=clients/python clients/python/examples/branch_and_search.py --game bigfish
"""

from __future__ import annotations

import argparse

import numpy as np

import procgen_client


def branch(
    pool: procgen_client.Pool, state: bytes, moves: int, random: np.random.Generator
) -> tuple[float, bytes, bool]:
    """Tries random moves from a state in all environments.

    Returns:
        The best return of the moves, the resulting state, and whether the episode ended.
    """
    pool.restore_states([state] * pool.env_count)
    returns = np.zeros(pool.env_count)
    running = np.ones(pool.env_count, bool)  # Later episodes do not count.
    for _ in range(moves):
        batch = pool.step(
            random.integers(0, procgen_client.ACTION_COUNT, pool.env_count),
            repeat_count=4,  # Repeated actions explore farther.
            observe=False,
        )
        returns[running] += batch.rewards[running]
        running &= ~batch.ended
    best = int(np.lexsort((~running, -returns))[0])
    return float(returns[best]), pool.save_states([best])[0], not running[best]


def search(
    pool: procgen_client.Pool, *, rounds: int, moves: int, random: np.random.Generator
) -> float:
    """Continues from the best state of each round; returns the total return."""
    state = pool.save_states([0])[0]
    total = 0.0
    for number in range(1, rounds + 1):
        gained, next_state, is_over = branch(pool, state, moves, random)
        total += gained
        ending = ", the episode is over" if is_over else ""
        print(f"round {number}: return {total:.1f}{ending}", flush=True)
        if is_over:
            break
        state = next_state
    return total


def main() -> None:
    """Reads the arguments and searches."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--server", help="address; default: PROCGEN_SERVER, else in this process")
    parser.add_argument("--game", default="bigfish", help="default: %(default)s")
    parser.add_argument("--level", type=int, default=7, help="default: %(default)s")
    parser.add_argument("--environments", type=int, default=64, help="default: %(default)s")
    parser.add_argument("--rounds", type=int, default=20, help="default: %(default)s")
    parser.add_argument("--moves", type=int, default=8, help="of a round; default: %(default)s")
    arguments = parser.parse_args()
    with procgen_client.Pool(
        arguments.game,
        arguments.environments,
        server=arguments.server,
        distribution_mode="easy",
        start_level=arguments.level,
        num_levels=1,
    ) as pool:
        total = search(
            pool,
            rounds=arguments.rounds,
            moves=arguments.moves,
            random=np.random.default_rng(0),
        )
    print(f"return {total:.1f} in level {arguments.level} of {arguments.game}")


if __name__ == "__main__":
    main()
