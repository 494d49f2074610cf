"""Data sets of frames, actions and rewards that are kept as seeds and actions.

``procgen-dataset`` (:mod:`procgen_client.dataset.cli`) records and replays; guides/data-sets.md of
the source tree has examples.

- :class:`TrajectoryDataset`: a data set for PyTorch, whose frames are drawn when they are read.
- :class:`Trajectories`, :func:`load`, :func:`from_actions`: trajectory files; the last makes one of
  actions that were taken elsewhere.
- :func:`parts_of`, :func:`record`: recordings. :func:`replay`, :func:`play`: their frames.
"""

from procgen_client.dataset.loader import TrajectoryDataset
from procgen_client.dataset.play import Block, Writer, play, replay
from procgen_client.dataset.recording import Part, from_actions, parts_of, record
from procgen_client.dataset.trajectories import Header, Trajectories, load

__all__ = [
    "Block",
    "Header",
    "Part",
    "Trajectories",
    "TrajectoryDataset",
    "Writer",
    "from_actions",
    "load",
    "parts_of",
    "play",
    "record",
    "replay",
]
