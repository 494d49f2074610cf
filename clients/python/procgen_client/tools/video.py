"""Videos of environments."""

from __future__ import annotations

import math
import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence

import numpy as np

from procgen_client._requests import in_range
from procgen_client.errors import InvalidArgumentError
from procgen_client.pool import Pool


class VideoRecorder:
    """Records environments of a pool, rendered for people, as an mp4 file; needs ffmpeg.

    A context manager: leaving it completes the file. Environments are arranged in a square grid.

    Attributes:
        path: Path of the file.
        frame_count: Number of captured frames.
    """

    def __init__(
        self,
        pool: Pool,
        path: str | os.PathLike[str],
        *,
        environments: Sequence[int] = (0,),
        size_px: int = 512,
        frames_per_second: int = 15,
    ) -> None:
        """Starts the file; overwrites an existing one.

        Args:
            pool: The pool (of a ProcgenVectorEnv: its attribute ``pool``).
            path: Path of the file, e.g. "coinrun.mp4".
            environments: Indices in the pool.
            size_px: Side of each environment's square frame in pixels, in [16, 2048].
            frames_per_second: In [1, 60]; people play at 15.

        Raises:
            FileNotFoundError: ffmpeg is not installed.
            InvalidArgumentError: A number is out of range.
        """
        if len(environments) == 0:
            raise InvalidArgumentError("environments is empty; it has at least one")
        program = shutil.which("ffmpeg")
        if program is None:
            raise FileNotFoundError("there is no program ffmpeg, which encodes videos; install it")
        self.path = os.fspath(path)
        self.frame_count = 0
        self._pool = pool
        self._environments = list(environments)
        self._size_px = in_range("size_px", size_px, 16, 2048)
        self._columns = math.ceil(math.sqrt(len(self._environments)))
        self._rows = math.ceil(len(self._environments) / self._columns)
        size = f"{self._columns * size_px}x{self._rows * size_px}"
        rate = str(in_range("frames_per_second", frames_per_second, 1, 60))
        # The codec requires even sides.
        even = "pad=ceil(iw/2)*2:ceil(ih/2)*2"
        self._said = tempfile.TemporaryFile()  # noqa: SIM115 - closed by close
        self._encoder = subprocess.Popen(
            [program, "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"]
            + ["-s", size, "-r", rate, "-i", "-", "-vf", even, "-an"]
            + ["-pix_fmt", "yuv420p", "-movflags", "+faststart", f"file:{self.path}"],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=self._said,
        )

    def __enter__(self) -> VideoRecorder:
        """Returns the recorder itself."""
        return self

    def __exit__(self, *exception: object) -> None:
        """Completes the file."""
        self.close()

    def capture(self) -> None:
        """Adds a frame of the environments' current states.

        Raises:
            OSError: ffmpeg has ended; the message has its output.
            ProcgenError: As Pool.render.
        """
        frame = self._tile(self._pool.render(self._environments, size_px=self._size_px))
        assert self._encoder.stdin is not None
        try:
            self._encoder.stdin.write(frame.tobytes())
        except (BrokenPipeError, ValueError):
            raise OSError(f"ffmpeg does not write {self.path}: {self._last_words()}") from None
        self.frame_count += 1

    def close(self) -> None:
        """Completes the file. Closing again does nothing.

        Raises:
            OSError: ffmpeg could not write the file; the message has its output.
        """
        if self._said.closed:
            return
        try:
            self._encoder.communicate()
            if self._encoder.returncode != 0 and self.frame_count > 0:
                raise OSError(f"ffmpeg did not write {self.path}: {self._last_words()}")
        finally:
            self._said.close()

    def _tile(self, pictures: list[np.ndarray]) -> np.ndarray:
        size = self._size_px
        frame = np.zeros((self._rows * size, self._columns * size, 3), np.uint8)
        for place, picture in enumerate(pictures):
            row, column = divmod(place, self._columns)
            frame[row * size : (row + 1) * size, column * size : (column + 1) * size] = picture
        return frame

    def _last_words(self) -> str:
        if self._said.closed:
            return "the recorder was closed"
        self._encoder.wait()
        self._said.seek(0)
        return self._said.read().decode(errors="replace").strip() or "it ended"
