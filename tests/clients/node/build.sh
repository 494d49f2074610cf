#!/usr/bin/env bash
# Builds the client in the working directory, unless it is newer than its sources. Argument: npm.
set -euo pipefail
npm=$1

if [[ package-lock.json -nt node_modules/.package-lock.json ]]; then
  "$npm" ci --ignore-scripts --no-audit --no-fund
fi
changed=$(find src/*.ts package.json tsconfig.json generate.sh ../../proto/procgen -newer dist/index.js 2>/dev/null || echo all)
if [[ -n $changed ]]; then
  "$npm" run build
fi
