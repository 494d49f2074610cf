#!/bin/sh
# Builds the agent and runs it: run.sh BUILD_FOLDER ADDRESS STEPS
# Needs node, npm, protoc.
set -e
here=$(cd "$(dirname "$0")" && pwd)
proto=$here/../../../proto
mkdir -p "$1/gen" && cd "$1"
cp "$here/package.json" "$here/random_agent.ts" .
npm install --silent || { echo "the npm registry is not reachable" >&2; exit 69; }
protoc -I "$proto" --plugin=node_modules/.bin/protoc-gen-ts_proto \
  --ts_proto_out=gen --ts_proto_opt=outputServices=grpc-js,esModuleInterop=true,forceLong=bigint \
  "$proto"/procgen/v1/*.proto
npx tsc --strict --esModuleInterop --skipLibCheck --target es2022 --module commonjs \
  --outDir out random_agent.ts
exec node out/random_agent.js "$2" "$3"
