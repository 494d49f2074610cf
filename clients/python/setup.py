"""Build hook: generates the modules of the protos before a wheel is built."""

import pathlib
import subprocess

from setuptools import setup
from setuptools.command.build_py import build_py

_HERE = pathlib.Path(__file__).resolve().parent


class GenerateAndBuild(build_py):
    """Runs generate.sh first, except in a source distribution, which has no protos."""

    def run(self) -> None:
        """Generates, then builds as usual."""
        if (_HERE / "../../proto/procgen/v1").is_dir():
            subprocess.run([_HERE / "generate.sh"], check=True)
        super().run()


# setuptools reads the list of packages before the modules are generated.
(_HERE / "procgen_client/_proto").mkdir(exist_ok=True)
setup(cmdclass={"build_py": GenerateAndBuild})
