#!/bin/sh
# Builds the agent and runs it: run.sh BUILD_FOLDER ADDRESS STEPS
# Needs ruby, grpc_tools_ruby_protoc.
set -e
here=$(cd "$(dirname "$0")" && pwd)
proto=$here/../../../proto
mkdir -p "$1"
grpc_tools_ruby_protoc -I "$proto" --ruby_out="$1" --grpc_out="$1" "$proto"/procgen/v1/*.proto
exec ruby -I "$1" "$here/random_agent.rb" "$2" "$3"
