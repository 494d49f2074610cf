#!/usr/bin/env bash
# Runs a test file with node, the first argument. Exits with 77 and a message without Chromium.
set -euo pipefail
node=$1
file=$2

if [[ ! -x ${PROCGEN_CHROMIUM:-} ]]; then
  echo "$file: skipped, there is no Chromium here (deploy/install-dependencies.sh installs it)"
  exit 77
fi
exec "$node" --test "$file"
