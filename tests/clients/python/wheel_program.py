#!/usr/bin/env python3
"""What tests run with an installed wheel: steps 64 environments in the process."""

import hashlib
import platform

import numpy as np
import procgen_client

assert "site-packages" in procgen_client.__file__, procgen_client.__file__
env = procgen_client.ProcgenVectorEnv(
    "coinrun", 64, distribution_mode="easy", rand_seed=3, autoreset_mode="SameStep"
)
digest = hashlib.sha256()
for t in range(50):
    observations, *_ = env.step((np.arange(64) * 5 + t) % 15)
    digest.update(observations.tobytes())
print(
    f"stepped {observations.shape}, Python {platform.python_version()}, NumPy {np.__version__}:",
    digest.hexdigest(),
)
