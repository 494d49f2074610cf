#!/usr/bin/env bash
# Builds and starts a server and steps 64 environments of each game. See --help.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

usage() {
  cat <<TEXT
Usage: deploy/quickstart.sh [--keep] [--nodes N] [--seconds S] [--environments N] [--output FILE]

Installs missing packages, builds everything and starts a server on a free port of this machine.
Steps environments of each game from Python, in the process and on the server, prints steps per
second, draws an image of the games and stops the server. Prints an address where a browser shows the
running server. Runs from any directory, any number of times. Needs root or sudo only if packages are
missing.

  --keep             leave the server running, with a pool that is stepped at watching speed, and print
                     its address for browsers, how to connect to it and how to stop it
  --nodes N          N servers, over which the Python program spreads its pools, 1 to 8 (default: 1)
  --seconds S        how long to step each game in each place, 1 to 600 (default: 1)
  --environments N   environments of each game, 2 to 4096 (default: 64)
  --output FILE      where to write the image, a .png file (default: ./quickstart.png)
  --help             print this and stop
TEXT
}

fail() {
  echo "deploy/quickstart.sh: $1" >&2
  echo "Try: deploy/quickstart.sh --help" >&2
  exit 2
}

# require_integer FLAG GIVEN LEAST MOST
require_integer() {
  if [[ ! $2 =~ ^[0-9]{1,6}$ ]] || ((10#$2 < $3 || 10#$2 > $4)); then
    fail "$1 is '$2'; it is a number from $3 to $4"
  fi
}

keep=()
nodes=()
seconds=1
environments=64
output=quickstart.png
while [[ $# -gt 0 ]]; do
  if [[ $1 == --*=* ]]; then
    set -- "${1%%=*}" "${1#*=}" "${@:2}"
  fi
  case "$1" in
    --keep) keep=(--keep); shift; continue ;;
    -h | --help) usage; exit 0 ;;
    --nodes | --seconds | --environments | --output) [[ $# -ge 2 ]] || fail "$1 needs a value" ;;
    *) fail "unknown argument '$1'" ;;
  esac
  case "$1" in
    --nodes) require_integer --nodes "$2" 1 8; nodes=(--nodes "$2") ;;
    --seconds) seconds=$2 ;;
    --environments) environments=$2 ;;
    --output) output=$2 ;;
  esac
  shift 2
done
require_integer --seconds "$seconds" 1 600
require_integer --environments "$environments" 2 4096
[[ $output == *.png ]] || fail "--output is '$output'; it ends in .png"
[[ -d $(dirname "$output") ]] || fail "--output is '$output'; there is no folder $(dirname "$output")"

"$root/deploy/install-dependencies.sh"

# The system's Python has the packages; one that is earlier in PATH may not.
python=
for candidate in "${PYTHON:-}" /usr/bin/python3 python3; do
  if [[ -n $candidate ]] && "$candidate" -c "import google.protobuf, numpy, PIL" 2>/dev/null; then
    python=$candidate
    break
  fi
done
[[ -n $python ]] || fail "found no Python with protobuf, numpy and PIL; set PYTHON=..."

echo "== Building the server and the Python client (some minutes the first time)"
(
  cd "$root"
  cmake --preset release -DPROCGEN_SYSTEM_PYTHON="$(command -v "$python")" --log-level=WARNING >/dev/null
  cmake --build --preset release --target procgen-server procgen-python-client
)

# The Python program starts the server, and stops it on every kind of exit.
export PYTHONPATH="$root/clients/python${PYTHONPATH:+:$PYTHONPATH}"
exec "$python" "$root/deploy/quickstart.py" --binary "$root/build/release/bin/procgen-server" \
  --log "$root/build/quickstart-server.log" --output "$output" \
  --seconds "$seconds" --environments "$environments" "${nodes[@]}" "${keep[@]}"
