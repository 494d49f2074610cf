#!/usr/bin/env python3
"""A random agent: PYTHONPATH=clients/python random_agent.py --game coinrun."""

import argparse

import numpy as np

from procgen_client import Pool

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--game", default="coinrun", help="default: %(default)s")
parser.add_argument("--server", help="address; default: PROCGEN_SERVER, else in this process")
arguments = parser.parse_args()
with Pool(arguments.game, 64, server=arguments.server) as pool:
    episodes = 0
    for _ in range(1000):
        episodes += pool.step(np.random.randint(0, 15, 64)).ended.sum()
    print(f"{episodes} episodes of {arguments.game}")
