"""Reference learners for Procgen: PPO and Rainbow in PyTorch, and the experiments of the paper."""
