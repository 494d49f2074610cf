#!/usr/bin/env bash
# Installs playwright-core and axe-core from the lock file, unless it is installed. Argument: npm.
set -euo pipefail
npm=$1

if [[ package-lock.json -nt node_modules/.package-lock.json ]]; then
  "$npm" ci --ignore-scripts --no-audit --no-fund
fi
