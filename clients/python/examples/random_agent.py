#!/usr/bin/env python3
"""A random agent: PYTHONPATH=clients/python random_agent.py localhost:50051 coinrun."""

import sys

import numpy as np

import procgen_client

server, game = sys.argv[1:] or ("localhost:50051", "coinrun")
with procgen_client.connect(server) as client, client.create_pool(game, 64) as pool:
    episodes = 0
    for _ in range(1000):
        episodes += pool.step(np.random.randint(0, 15, 64)).ended.sum()
    print(f"{episodes} episodes of {game}")
