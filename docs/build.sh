#!/usr/bin/env bash
# Builds the documentation site. See --help.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

usage() {
  cat <<TEXT
Usage: docs/build.sh [--build FOLDER] [--output FOLDER]

Builds the documentation site: static pages with search, to be opened from disk or served by any web server. Needs
deploy/install-dependencies.sh --docs --learners, and a build with the target procgen-gallery.

  --build FOLDER   build folder of CMake (build/release)
  --output FOLDER  where the site is written (FOLDER of --build/docs/site)
  --help           print this and stop
TEXT
}

build=$root/build/release
output=
while [[ $# -gt 0 ]]; do
  case "$1" in
    --build) build=$(realpath "${2:?--build needs a folder}"); shift 2 ;;
    --output) output=$(realpath -m "${2:?--output needs a folder}"); shift 2 ;;
    -h | --help) usage; exit 0 ;;
    *)
      echo "docs/build.sh: unknown argument '$1'" >&2
      echo "Try: docs/build.sh --help" >&2
      exit 2
      ;;
  esac
done
output=${output:-$build/docs/site}
sources=$build/docs/source
sheets=$build/docs/sheets

for file in bin/procgen-gallery lib/libprocgen.so.1 lib/libprocgen_remote.so.1; do
  if [[ ! -e $build/$file ]]; then
    echo "docs/build.sh: $build/$file is missing; build the targets procgen-gallery and procgen-python-client" >&2
    exit 1
  fi
done
export PROCGEN_LIBRARY=$build/lib/libprocgen.so.1 PROCGEN_REMOTE_LIBRARY=$build/lib/libprocgen_remote.so.1
export PYTHONPATH=$root/clients/python PYTHONDONTWRITEBYTECODE=1

if [[ ! $sheets/games.png -nt $build/bin/procgen-gallery ]]; then
  "$build/bin/procgen-gallery" "$sheets"
fi
python=${PYTHON:-/usr/bin/python3}
"$python" "$root/docs/generate.py" "$sources" "$sheets"
cp "$root/docs/conf.py" "$sources/conf.py"
mkdir -p "$sources/_site" && cp "$root/docs/site.css" "$sources/_site/site.css"
"$python" -m sphinx -W --keep-going -q -b html -d "$build/docs/doctrees" "$sources" "$output"
# Debian's furo has an unbundled script, and a style sheet that imports a file of Debian's web root.
esbuild "$output/_static/scripts/furo.js" --bundle --log-level=error --allow-overwrite --outfile="$output/_static/scripts/furo.js"
sed -i '/^@import url(\/javascript\//d' "$output/_static/styles/furo.css"
echo "The site is $output/index.html"
