#!/bin/sh
# Builds the agent and runs it: run.sh BUILD_FOLDER ADDRESS STEPS
# Needs cargo, protoc.
set -e
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1" && cd "$1"
cp "$here/Cargo.toml" "$here/build.rs" "$here/random_agent.rs" .
cargo fetch --quiet || { echo "crates.io is not reachable" >&2; exit 69; }
PROCGEN_PROTO=$here/../../../proto cargo build --quiet --release
exec target/release/random-agent "$2" "$3"
