#!/usr/bin/env bash
# Installs missing dependencies, builds, runs the tests and prints how many passed. See --help.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
known_presets="dev release asan tsan lint fuzz"

usage() {
  cat <<TEXT
Usage: tests/run.sh [--preset NAME] [--label LABEL]... [--all] [--help]

Installs what is missing, builds and runs the tests. The last line is "N passed, M failed"; the exit
status is 0 only if every test that ran passed and at least one ran.

  --preset NAME   build with this preset: ${known_presets// /, } (default: dev)
  --label LABEL   run only the tests with this label (unit, playthrough, service, fuzz, slow);
                  may be given more than once
  --all           run the tests with the labels slow and fuzz as well; they are left out otherwise,
                  unless --label names them
  --help          print this and stop
TEXT
}

fail() {
  echo "tests/run.sh: $1" >&2
  echo "Try: tests/run.sh --help" >&2
  exit 2
}

# Fails unless flag $1 is followed by a value; $2: number of remaining arguments, including the
# flag.
require_value() {
  [[ $2 -ge 2 ]] || fail "$1 needs a value"
}

preset=dev
labels=()
all=no
while [[ $# -gt 0 ]]; do
  case "$1" in
    --preset) require_value "$1" $#; preset=$2; shift 2 ;;
    --preset=*) preset=${1#*=}; shift ;;
    --label) require_value "$1" $#; labels+=("$2"); shift 2 ;;
    --label=*) labels+=("${1#*=}"); shift ;;
    --all) all=yes; shift ;;
    -h | --help) usage; exit 0 ;;
    *) fail "unknown argument '$1'" ;;
  esac
done
[[ " $known_presets " == *" $preset "* ]] ||
  fail "unknown preset '$preset'; the presets are ${known_presets// /, }"
for label in "${labels[@]}"; do
  [[ $label =~ ^[a-z]+$ ]] || fail "bad label '$label'; a label is one word of small letters"
done

# The tests to run: those of --label, without the heavy labels that were not requested.
filter=()
if [[ ${#labels[@]} -gt 0 ]]; then
  filter+=(--label-regex "^($(IFS='|'; echo "${labels[*]}"))\$")
fi
if [[ $all == no ]]; then
  excluded=()
  for heavy in slow fuzz; do
    [[ " ${labels[*]-} " == *" $heavy "* ]] || excluded+=("$heavy")
  done
  if [[ ${#excluded[@]} -gt 0 ]]; then
    filter+=(--label-exclude "^($(IFS='|'; echo "${excluded[*]}"))\$")
  fi
fi

cd "$root"
dependencies=(--tests)
[[ $preset != lint && $preset != fuzz ]] || dependencies+=(--clang)
[[ $all == no && " ${labels[*]-} " != *" slow "* ]] || dependencies+=(--slow)
"$root/deploy/install-dependencies.sh" "${dependencies[@]}"
echo "== Configuring (preset $preset)"
configuration=(-DPROCGEN_BUILD_TESTS=ON)
# The tests of benchmarks have the label slow. Builds with sanitizers have none.
if [[ $preset == dev || $preset == release ]] && [[ $all == yes || " ${labels[*]-} " == *" slow "* ]]; then
  configuration+=(-DPROCGEN_BUILD_BENCHMARKS=ON)
fi
cmake --preset "$preset" "${configuration[@]}"
echo "== Building"
cmake --build --preset "$preset" --parallel "$(nproc)"

echo "== Testing"
results="$root/build/$preset/test-results.xml"
rm -f "$results"
ctest_status=0
# One more than there are cores, because many tests wait for processes.
ctest --preset "$preset" --parallel "$(($(nproc) + 1))" --output-junit "$results" "${filter[@]}" || ctest_status=$?
python3 "$root/tests/count_results.py" "$results" --ctest-status "$ctest_status"
