#!/usr/bin/env bash
# Generates src/generated/ from the protos. Needs protobuf-compiler, and npm ci to have run.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
protos=${PROCGEN_PROTOS:-$here/../../proto}

rm -rf "$here/src/generated"
mkdir -p "$here/src/generated"
"${PROTOC:-protoc}" --proto_path="$protos" \
  --plugin="$here/node_modules/.bin/protoc-gen-es" \
  --es_out="$here/src/generated" --es_opt=target=ts,import_extension=js \
  "$protos"/procgen/v1/*.proto
