#!/bin/sh
# Builds the agent and runs it: run.sh BUILD_FOLDER ADDRESS STEPS
# Needs javac, mvn.
set -e
here=$(cd "$(dirname "$0")" && pwd)
libraries=${PROCGEN_LIBRARIES:-$here/../../../build/release/lib}
jna=net.java.dev.jna:jna:5.17.0
mkdir -p "$1" && cd "$1"
mvn -q -B dependency:copy -Dartifact=$jna -DoutputDirectory=. ||
  { echo "Maven Central is not reachable" >&2; exit 69; }
javac -cp jna-5.17.0.jar -d . "$here/RandomAgent.java"
exec java -Djna.library.path="$libraries" -cp jna-5.17.0.jar:. RandomAgent "$2" "$3"
