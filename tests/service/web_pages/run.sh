#!/usr/bin/env bash
# Runs a test file by node, the first argument; says so and exits with 77 where there is no Chromium to run it in.
set -euo pipefail
node=$1
file=$2

if [[ ! -x ${PROCGEN_CHROMIUM:-} ]]; then
  echo "$file: skipped, there is no Chromium here (deploy/install-dependencies.sh installs it)"
  exit 77
fi
exec "$node" --test "$file"
