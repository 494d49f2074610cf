#!/bin/sh
# Generates the Python modules of proto/procgen/v1 into procgen_client/_proto/ (which git ignores).
#
# Usage: generate.sh [OUTPUT_DIRECTORY]
#
# The modules are not in a package `procgen.v1`, since the package of Procgen 0.10.7 has that name.
# Their imports are rewritten; the names of the files in protobuf's registry do not change.
# Files are replaced atomically, so that two builds may run this at a time.
set -eu

here=$(cd "$(dirname "$0")" && pwd)
protos=$here/../../proto
output=${1:-$here/procgen_client/_proto}
protoc=${PROTOC:-protoc}

if [ ! -d "$protos/procgen/v1" ]; then
  echo "generate.sh: no $protos/procgen/v1; run it from a checkout" >&2
  exit 1
fi
if ! command -v "$protoc" >/dev/null; then
  echo "generate.sh: $protoc is missing; on Debian: apt install protobuf-compiler" >&2
  exit 1
fi

mkdir -p "$output"
work=$(mktemp -d "$output/.generating.XXXXXX")
trap 'rm -rf "$work"' EXIT

"$protoc" --proto_path="$protos" --python_out="$work" --pyi_out="$work" \
  "$protos"/procgen/v1/*.proto

for file in "$work"/procgen/v1/*.py "$work"/procgen/v1/*.pyi; do
  sed -i -e 's/^from procgen\.v1 import /from procgen_client._proto import /' \
    -e "s/'procgen\.v1\.\([a-z_]*_pb2\)'/'procgen_client._proto.\1'/" "$file"
  mv "$file" "$output/$(basename "$file")"
done
echo '"""Generated from proto/procgen/v1 by generate.sh."""' >"$work/__init__.py"
mv "$work/__init__.py" "$output/__init__.py"
