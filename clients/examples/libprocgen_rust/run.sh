#!/bin/sh
# Builds the agent and runs it: run.sh BUILD_FOLDER ADDRESS STEPS
# Needs rustc.
set -e
here=$(cd "$(dirname "$0")" && pwd)
libraries=${PROCGEN_LIBRARIES:-$here/../../../build/release/lib}
mkdir -p "$1"
rustc --edition 2021 -O -L "$libraries" -C link-arg=-Wl,-rpath,"$libraries" -o "$1/random_agent" \
  "$here/random_agent.rs"
exec "$1/random_agent" "$2" "$3"
