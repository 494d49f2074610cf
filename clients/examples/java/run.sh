#!/bin/sh
# Builds the agent and runs it: run.sh BUILD_FOLDER ADDRESS STEPS
# Needs javac, mvn.
set -e
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1/src/main/java" && cd "$1"
cp "$here/pom.xml" .
cp "$here/RandomAgent.java" src/main/java/
rm -rf proto && cp -r "$here/../../../proto" proto
mvn -q -B dependency:resolve || { echo "Maven Central is not reachable" >&2; exit 69; }
mvn -q -B compile
exec mvn -q -B exec:java -Dexec.args="$2 $3"
