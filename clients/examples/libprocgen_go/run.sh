#!/bin/sh
# Builds the agent and runs it: run.sh BUILD_FOLDER ADDRESS STEPS
# Needs go, cc.
set -e
here=$(cd "$(dirname "$0")" && pwd)
libraries=${PROCGEN_LIBRARIES:-$here/../../../build/release/lib}
mkdir -p "$1"
CGO_CFLAGS="-I$here/../../c" CGO_LDFLAGS="-L$libraries -lprocgen_remote -Wl,-rpath,$libraries" CGO_ENABLED=1 \
  go build -o "$1/random_agent" "$here/random_agent.go"
exec "$1/random_agent" "$2" "$3"
