#!/bin/sh
# Builds the agent and runs it: run.sh BUILD_FOLDER ADDRESS STEPS
# Needs go, protoc.
set -e
here=$(cd "$(dirname "$0")" && pwd)
proto=$here/../../../proto
mkdir -p "$1" && cd "$1"
cp "$here/go.mod" "$here/random_agent.go" .
{
  GOBIN=$PWD/bin go install google.golang.org/protobuf/cmd/protoc-gen-go@v1.36.10 &&
    GOBIN=$PWD/bin go install google.golang.org/grpc/cmd/protoc-gen-go-grpc@v1.5.1
} || { echo "the Go module proxy is not reachable" >&2; exit 69; }
PATH=$PWD/bin:$PATH protoc -I "$proto" --go_out=. --go_opt=module=procgen \
  --go-grpc_out=. --go-grpc_opt=module=procgen "$proto"/procgen/v1/*.proto
go mod tidy
exec go run . "$2" "$3"
