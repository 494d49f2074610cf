"""Build hook: a wheel with the engine, for every Python version of one platform.

From a checkout on Linux. Variables: PROCGEN_WHEEL_MACHINE (aarch64: cross-compiled),
PROCGEN_WHEEL_REMOTE=1 (also the library for servers), PROCGEN_WHEEL_LIBRARIES (a folder with built
libraries: nothing is compiled).
"""

import os
import pathlib
import platform
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))  # Not so in pip's own process.

import bundle
from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

try:
    from setuptools.command.bdist_wheel import bdist_wheel
except ImportError:  # before setuptools 70.1
    from wheel.bdist_wheel import bdist_wheel

_HERE = pathlib.Path(__file__).resolve().parent
_CHECKOUT = _HERE.parent.parent
_MACHINE = os.environ.get("PROCGEN_WHEEL_MACHINE") or platform.machine()


class Build(build_py):
    """Generates the modules of the protos, and builds and bundles the libraries."""

    def run(self) -> None:
        """Builds."""
        if platform.system() != "Linux" or not (_CHECKOUT / "proto/procgen/v1").is_dir():
            sys.exit("error: the package is built on Linux, from a checkout of Procgen Server")
        bundle.require_tools({"protoc": "protobuf-compiler"})
        subprocess.run([_HERE / "generate.sh"], check=True)
        super().run()
        if not self.editable_mode:
            package = pathlib.Path(self.build_lib) / "procgen_client"
            given = os.environ.get("PROCGEN_WHEEL_LIBRARIES")
            with_remote = os.environ.get("PROCGEN_WHEEL_REMOTE") == "1"
            built = (
                pathlib.Path(given) if given else bundle.build(_CHECKOUT, _MACHINE, with_remote)
            )
            bundle.copy_libraries(built, package, _MACHINE)
            bundle.copy_protobuf(package)
            shutil.copy2(_CHECKOUT / "clients/c/procgen.h", package)
            shutil.copy2(_CHECKOUT / "LICENSE", package / "licenses/procgen-server")


class Wheel(bdist_wheel):
    """A wheel for one platform and every Python version."""

    def get_tag(self) -> tuple[str, str, str]:
        """Returns the tag: the platform is the oldest one whose C library is new enough."""
        folder = pathlib.Path(self.get_finalized_command("build_py").build_lib) / "procgen_client"
        return "py3", "none", bundle.platform_tag(folder, _MACHINE)


class PlatformDistribution(Distribution):
    """A distribution that is not pure Python."""

    def has_ext_modules(self) -> bool:
        """Whether it is for one platform."""
        return True


# setuptools reads the list of packages before the modules are generated.
(_HERE / "procgen_client/_proto").mkdir(exist_ok=True)
# What an earlier build left, perhaps of another machine, does not belong into it.
shutil.rmtree(_HERE / "build", ignore_errors=True)
setup(distclass=PlatformDistribution, cmdclass={"build_py": Build, "bdist_wheel": Wheel})
