#!/bin/sh
# Builds the wheel procgen_server-VERSION-py3-none-manylinux_*.whl: the package with the engine, for every Python version.
#
# Usage: build_wheel.sh [--remote] [--machine aarch64] [OUTPUT_DIRECTORY]     (default: dist)
#
#   --remote           also the library for servers, with gRPC; takes several minutes, and the wheel needs a newer system
#   --machine aarch64  cross-compiles for 64-bit ARM
#
# Missing Debian packages are installed first. Two builds of a commit are equal, byte for byte.
set -eu

here=$(cd "$(dirname "$0")" && pwd)
checkout=$here/../..
python=${PYTHON:-/usr/bin/python3}
output=dist
packages=--library
while [ $# -gt 0 ]; do
  case $1 in
    --remote)
      export PROCGEN_WHEEL_REMOTE=1
      packages=--wheel
      ;;
    --machine)
      export PROCGEN_WHEEL_MACHINE="${2:?--machine needs x86_64 or aarch64}"
      [ "$2" = "$(uname -m)" ] || packages="--library --$2"
      shift
      ;;
    -*)
      echo "build_wheel.sh: unknown option $1; see the comment in $0" >&2
      exit 2
      ;;
    *) output=$1 ;;
  esac
  shift
done

# shellcheck disable=SC2086  # several options
"$checkout/deploy/install-dependencies.sh" $packages

# The time of the files in the wheel: 2020, everywhere.
export SOURCE_DATE_EPOCH="${SOURCE_DATE_EPOCH:-1577836800}"
umask 022
mkdir -p "$output"
"$python" -m pip wheel --no-build-isolation --no-index --no-deps --disable-pip-version-check \
  --wheel-dir "$output" "$here"
ls -l "$output"/procgen_server-*.whl
