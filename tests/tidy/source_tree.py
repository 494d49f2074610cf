"""The files of the repository, as input of the tidy rules."""

import dataclasses
import functools
import pathlib
import posixpath
import subprocess


@dataclasses.dataclass(frozen=True, order=True)
class Violation:
    """A place that violates a rule; `message` has the problem and its remedy."""

    path: str
    line: int
    message: str

    def __str__(self):
        return f"{self.path}:{self.line}: {self.message}"


class SourceTree:
    """Paths, relative to the root with '/', and texts; binary files have no text."""

    def __init__(self, texts):
        """`texts`: a dictionary from path to text, or to None for a binary file."""
        self._texts = dict(texts)

    @property
    def paths(self):
        return sorted(self._texts)

    def __contains__(self, path):
        return path in self._texts

    def text(self, path):
        return self._texts[path] or ""

    def lines(self, path):
        """Pairs of line number, from 1, and line."""
        return list(enumerate(self.text(path).splitlines(), start=1))

    def with_suffix(self, *suffixes):
        return [path for path in self.paths if path.endswith(suffixes)]

    @functools.cached_property
    def folders(self):
        """All folders; the root is ''."""
        found = {""}
        for path in self._texts:
            folder = posixpath.dirname(path)
            while folder:
                found.add(folder)
                folder = posixpath.dirname(folder)
        return sorted(found)

    @staticmethod
    def read(root):
        """Reads what git tracks below `root`; without git all but hidden and built files."""
        root = pathlib.Path(root)
        return SourceTree({path: _read_text(root / path) for path in list_files(root)})


def list_files(root):
    """Returns the paths of the project's files below `root`."""
    root = pathlib.Path(root)
    # safe.directory: the tests may run as root in a checkout of another user.
    command = ["git", "-c", "safe.directory=*", "-C", str(root), "ls-files", "-z"]
    try:
        output = subprocess.run(command, capture_output=True, check=True).stdout.decode()
        paths = output.split("\0")
    except (OSError, subprocess.CalledProcessError):
        paths = [path.relative_to(root).as_posix() for path in root.rglob("*")]
        paths = [path for path in paths
                 if not path.startswith((".", "build/")) and "__pycache__" not in path]
    return sorted(path for path in paths if path and (root / path).is_file())


def _read_text(path):
    data = path.read_bytes()
    # A recorded message may happen to be valid text.
    if path.suffix == ".bin" or b"\0" in data:
        return None
    try:
        return data.decode()
    except UnicodeDecodeError:
        return None
