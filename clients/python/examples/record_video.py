#!/usr/bin/env python3
"""Records four environments as an mp4 file; needs the program ffmpeg.

    PYTHONPATH=clients/python clients/python/examples/record_video.py coinrun.mp4
"""

import argparse

import numpy as np

from procgen_client import Pool, VideoRecorder

parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
parser.add_argument("path", nargs="?", default="coinrun.mp4", help="default: %(default)s")
parser.add_argument("--server", help="address; default: PROCGEN_SERVER, else in this process")
arguments = parser.parse_args()
with Pool("coinrun", 4, server=arguments.server) as pool:
    with VideoRecorder(pool, arguments.path, environments=range(4), size_px=256) as video:
        for _ in range(100):
            video.capture()
            pool.step(np.random.randint(0, 15, 4))
    print(f"{video.frame_count} frames in {video.path}")
