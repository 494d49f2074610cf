"""Environments with the interfaces of Gymnasium, gym3 and the released package."""
