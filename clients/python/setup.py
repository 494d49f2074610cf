"""Build hook: native parts and generated modules of a wheel.

From a checkout on Linux (x86-64) the wheel has everything: the native module, the programs
procgen-server and procgen-top, the shared libraries that they need, and protobuf. With the
environment variable PROCGEN_WHEEL=pure, and elsewhere, it has Python alone, and grpcio carries the
calls. Both have the modules of the protos, generated from the checkout.
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

_HERE = pathlib.Path(__file__).resolve().parent
_CHECKOUT = _HERE.parent.parent
_IS_BUNDLED = (
    (_CHECKOUT / "CMakeLists.txt").is_file()
    and platform.system() == "Linux"
    and platform.machine() == "x86_64"
    and os.environ.get("PROCGEN_WHEEL") != "pure"
)


class Build(build_py):
    """Generates the modules of the protos, and builds and bundles the native parts."""

    def run(self) -> None:
        """Builds. In a source distribution there are no protos: their modules are there."""
        if (_CHECKOUT / "proto/procgen/v1").is_dir():
            bundle.require_tools({"protoc": "protobuf-compiler",
                                  "grpc_python_plugin": "protobuf-compiler-grpc"})
            subprocess.run([_HERE / "generate.sh"], check=True)
        super().run()
        package = pathlib.Path(self.build_lib) / "procgen_client"
        if _IS_BUNDLED and not self.editable_mode:
            bundle.build(_CHECKOUT, package)
        if (_CHECKOUT / "LICENSE").is_file() and not self.editable_mode:
            (package / "licenses").mkdir(exist_ok=True)
            shutil.copy2(_CHECKOUT / "LICENSE", package / "licenses/procgen-server")


class BundledDistribution(Distribution):
    """A wheel with native parts is for one platform."""

    def has_ext_modules(self) -> bool:
        """Whether it has native parts."""
        return _IS_BUNDLED


# setuptools reads the list of packages before the modules are generated.
(_HERE / "procgen_client/_proto").mkdir(exist_ok=True)
if not _IS_BUNDLED and (_HERE / "build").is_dir():
    shutil.rmtree(_HERE / "build")  # Native parts of an earlier build do not belong into it.
setup(
    distclass=BundledDistribution,
    cmdclass={"build_py": Build},
    install_requires=["numpy>=1.24"]
    + ([] if _IS_BUNDLED else ["grpcio>=1.51", "protobuf>=4.21"]),
    entry_points={
        "console_scripts": [
            "procgen-evaluate = procgen_client.tools.evaluate:main",
            *(
                f"{program} = procgen_client.tools.programs:run"
                for program in bundle.PROGRAMS
                if _IS_BUNDLED
            ),
        ]
    },
)
