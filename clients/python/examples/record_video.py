#!/usr/bin/env python3
"""Records four environments as an mp4 file; needs the program ffmpeg.

    PYTHONPATH=clients/python clients/python/examples/record_video.py localhost:50051 coinrun.mp4
"""

import sys

import numpy as np

import procgen_client

server, path = sys.argv[1:] or ("localhost:50051", "coinrun.mp4")
with procgen_client.connect(server) as client, client.create_pool("coinrun", 4) as pool:
    with procgen_client.VideoRecorder(pool, path, environments=range(4), size_px=256) as video:
        for _ in range(100):
            video.capture()
            pool.step(np.random.randint(0, 15, 4))
    print(f"{video.frame_count} frames in {path}")
