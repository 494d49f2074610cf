"""Environments with the interfaces of Gymnasium, gym3 and Procgen 0.10.7."""
