#!/usr/bin/env python3
"""A learner that steps a pool of a server once for each line of its input.

Arguments: the server's address, and the arguments of Pool as JSON. Each line of the input has those
of Pool.step as JSON. Prints the pool's name, and after each step the SHA-256 of its observations.
The end of the input closes the pool.
"""

from __future__ import annotations

import hashlib
import json
import sys

from procgen_client import Pool


def main() -> None:
    """Runs the learner."""
    _, server, options = sys.argv
    with Pool(server=server, **json.loads(options)) as pool:
        print(pool.name, flush=True)
        for line in sys.stdin:
            batch = pool.step(**json.loads(line))
            print(hashlib.sha256(batch.observations).hexdigest(), flush=True)


if __name__ == "__main__":
    main()
