"""Environments with the APIs of Gymnasium, gym3 and Procgen 0.10.7."""
