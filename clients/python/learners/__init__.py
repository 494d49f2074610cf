"""Reference learners for Procgen: PPO and Rainbow in PyTorch, and the experiments of the paper."""

import os

# Read when NumPy is loaded. Threads around operators do better than those in them (gradients.py).
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
