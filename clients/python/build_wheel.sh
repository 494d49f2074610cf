#!/bin/sh
# Builds the wheel procgen_server-VERSION-...-linux_x86_64.whl, which has everything, and the pure
# wheel procgen_server-VERSION-py3-none-any.whl, the client for other platforms.
#
# Usage: build_wheel.sh [OUTPUT_DIRECTORY]     (default: dist)
set -eu

here=$(cd "$(dirname "$0")" && pwd)
output=${1:-dist}
python=${PYTHON:-/usr/bin/python3}

mkdir -p "$output"
for kind in bundled pure; do
  PROCGEN_WHEEL=$kind "$python" -m pip wheel --no-build-isolation --no-index --no-deps --disable-pip-version-check \
    --wheel-dir "$output" "$here"
done
ls -l "$output"/procgen_server-*.whl
