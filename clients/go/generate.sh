#!/usr/bin/env bash
# Generates procgenv1/ from the protos. Needs protobuf-compiler, protoc-gen-go and protoc-gen-go-grpc.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
protos=${PROCGEN_PROTOS:-$here/../../proto}
package=procgenclient/procgenv1

options=()
for proto in "$protos"/procgen/v1/*.proto; do
  name=procgen/v1/$(basename "$proto")
  options+=("--go_opt=M$name=$package" "--go-grpc_opt=M$name=$package")
done
mkdir -p "$here/procgenv1"
"${PROTOC:-protoc}" --proto_path="$protos" \
  --go_out="$here" --go_opt=module=procgenclient \
  --go-grpc_out="$here" --go-grpc_opt=module=procgenclient \
  "${options[@]}" "$protos"/procgen/v1/*.proto
