"""Build hook: the package is in a folder of its own, last in Python's path.

So it overwrites no file of an installed package `procgen`, and Python finds that one first.
"""

import pathlib
import sys
import sysconfig
from importlib import metadata

from setuptools import setup
from setuptools.command.build_py import build_py

_FOLDER = "procgen_server_procgen"


class Build(build_py):
    """Adds the file that puts the folder into Python's path."""

    def run(self) -> None:
        """Builds."""
        # The environment of this interpreter, also in pip's isolated build.
        paths = [sysconfig.get_path("purelib"), sysconfig.get_path("platlib")]
        for found in metadata.distributions(name="procgen", path=paths):
            sys.exit(
                f"error: the distribution procgen {found.version} is installed, and Python finds "
                "its package procgen first: pip uninstall procgen"
            )
        super().run()
        pathlib.Path(self.build_lib, f"{_FOLDER}.pth").write_text(f"{_FOLDER}\n")


setup(cmdclass={"build_py": Build})
