"""Build hook: a wheel built in a checkout holds modules generated from that checkout's protos."""

import pathlib
import subprocess

from setuptools import setup
from setuptools.command.build_py import build_py

_HERE = pathlib.Path(__file__).resolve().parent


class GenerateAndBuild(build_py):
    """Runs generate.sh first, unless there are no protos: in a source distribution."""

    def run(self) -> None:
        """Generates, then builds as usual."""
        if (_HERE / "../../proto/procgen/v1").is_dir():
            subprocess.run([_HERE / "generate.sh"], check=True)
        super().run()


# What reads the package's metadata wants the folder, before anything is generated.
(_HERE / "procgen_client/_proto").mkdir(exist_ok=True)
setup(cmdclass={"build_py": GenerateAndBuild})
