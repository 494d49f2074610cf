#!/usr/bin/env bash
# Fetches what drives the browser, as the lock file says, unless it is there. The argument is npm.
set -euo pipefail
npm=$1

if [[ package-lock.json -nt node_modules/.package-lock.json ]]; then
  "$npm" ci --ignore-scripts --no-audit --no-fund
fi
