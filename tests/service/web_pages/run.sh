#!/usr/bin/env bash
# Runs a test file with node. Exits with 77 and a message without its browser. Arguments: node, the file, the browser, which
# is Chromium or Firefox. Its program is in PROCGEN_CHROMIUM or PROCGEN_FIREFOX.
set -euo pipefail
node=$1
file=$2
browser=$3

program=PROCGEN_${browser^^}
if [[ ! -x ${!program:-} ]]; then
  echo "$file: skipped, there is no $browser here (deploy/install-dependencies.sh --tests --slow installs it)"
  exit 77
fi
exec "$node" --test "$file"
