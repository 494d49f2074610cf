#!/usr/bin/env bash
# Installs the missing Debian packages for building, running and testing. See --help.
set -euo pipefail

# Packages for building, packaging and the Python client, with their purpose. All are in Debian 12 and 13.
packages=(
  g++                     # the compiler
  cmake                   # the build
  ninja-build             # build tool
  pkg-config              # finds libraries without a CMake package
  libgrpc++-dev           # transport of the server and the C++ client
  libssl-dev              # reads certificates, hashes tokens
  libprotobuf-dev         # messages
  protobuf-compiler       # generates messages
  protobuf-compiler-grpc  # generates service stubs, C++ and Python
  libabsl-dev             # status, strings, containers, synchronisation
  libspdlog-dev           # log lines
  libzstd-dev             # compresses observations
  prometheus-cpp-dev      # metrics
  cyclonedds-dev          # discovery in a cluster
  cyclonedds-tools        # compiles its message types
  esbuild                 # bundles the web pages
  libboost-dev            # HTTP and WebSocket of the web pages
  libstb-dev              # reads art
  libpng-dev              # writes PNG
  librsvg2-bin            # rasterises the art while building
  nlohmann-json3-dev      # recordings and messages of the web pages
  zlib1g-dev              # compresses them
  python3                 # the Python client, the quickstart, some tests
  python3-protobuf        # its messages to servers
  python3-numpy           # its arrays
  python3-pil             # draws the quickstart's image
  dpkg-dev                # finds dependencies of the Debian packages
  file                    # finds programs in them
  fonts-dejavu-core       # font of the quickstart's image
)

# Further packages for the tests: a browser, checking tools.
test_packages=(
  python3-grpcio          # servers of tests, procgen-dm-env-rpc
  git                     # lists the files of the tidy test
  clang-format            # checks their format
  libgtest-dev            # tests
  libgmock-dev            # matchers of the tests
  libcpp-httplib-dev      # their HTTP client
  libbenchmark-dev        # benchmarks
  openssl                 # makes the certificates of the tests
  man-db                  # renders the manual pages
  python3-pytest          # the Python client's tests
  python3-websockets      # stands in for the web pages in tests
  mypy                    # checks its types
  ffmpeg                  # its videos
  nodejs                  # runs the tests of the web pages; npm fetches the rest
  chromium-headless-shell # browser for tests of the web pages
  python3-yaml            # the tests of deploy/ read manifests
  kubernetes-client       # renders the Kubernetes manifests
  iproute2                # private networks for tests
  nftables                # network partitions in tests
)

# What clients/python/learners needs. The tests need it as well.
learner_packages=(
  python3-torch           # networks, on the CPU
  libopenblas0-pthread    # its linear algebra; the reference BLAS takes 20 times as long
)
test_packages+=("${learner_packages[@]}")

# What clients/python/build_wheel.sh needs. The tests need it as well.
wheel_packages=(
  python3-pip             # builds the wheel
  python3-wheel           # its format
  python3-setuptools      # its build backend
  patchelf                # bundles libraries into it
)
test_packages+=("${wheel_packages[@]}")

# What libprocgen and a wheel without the library for servers need: those that --library installs instead of all above.
library_packages=(
  g++                     # the compiler
  cmake                   # the build
  ninja-build             # build tool
  libabsl-dev             # strings
  nlohmann-json3-dev      # the catalog
  libstb-dev              # reads art
  zlib1g-dev              # decompresses it
  librsvg2-bin            # rasterises the art while building
  protobuf-compiler       # generates the Python client's messages
  libprotobuf-dev         # the protos that these import
  python3                 # builds the wheel
  python3-protobuf        # bundled
  "${wheel_packages[@]}"
)

# What a cross build for 64-bit ARM needs beside these.
aarch64_packages=(
  crossbuild-essential-arm64
  libabsl-dev:arm64
  zlib1g-dev:arm64
)

# npm is part of some packages of nodejs, which conflict with Debian's npm.
command -v npm >/dev/null || test_packages+=(npm)

# Further packages for the presets lint and fuzz.
clang_packages=(
  clang                   # the compiler of both presets
  clang-tidy              # the linter
  libclang-rt-14-dev      # libFuzzer and the sanitizers of that compiler
)

# Packages for plots of clients/python: returns and scores.
plot_packages=(
  python3-matplotlib
)

# What docs/build.sh needs beside a build and the learners' packages. The slow tests need it as well.
docs_packages=(
  python3-sphinx          # generates the site
  python3-myst-parser     # reads its Markdown
  furo                    # its theme
)

# Packages for tests with the label slow: building and running images, checking Prometheus rules, a second browser.
slow_packages=(
  mmdebstrap              # creates a Debian root without an image registry
  buildah                 # builds images
  podman                  # runs them
  runc                    # its runtime, which also supports cgroup v1
  prometheus              # promtool
  nginx                   # the front of deploy/front
  firefox-esr             # another browser for tests of the web pages
  "${docs_packages[@]}"
  python3-venv            # environments with other libraries, for tests of the Python client
)

usage() {
  cat <<TEXT
Usage: deploy/install-dependencies.sh [--library] [--aarch64] [--tests] [--clang] [--plot] [--docs] [--slow] [--list] [--help]

Installs, with apt, the missing packages for building Procgen Server and its Python client. If none is missing, apt is
not called. Otherwise needs root or sudo.

  --library  only packages for libprocgen and the Python wheel, without the server; before other options
  --aarch64  also packages for the preset library-aarch64
  --tests  also packages for the tests
  --learners  and what clients/python/learners needs, PyTorch above all (with the tests' packages, too)
  --wheel  also packages that build the Python wheel (with the tests' packages, too)
  --clang  also packages for the presets lint and fuzz
  --plot   also packages that draw plots of returns and scores
  --docs   also packages that build the documentation site (with the slow tests' packages, too)
  --slow   also packages for tests with the label slow
  --list   print the names of the packages and stop
  --help   print this and stop
TEXT
}

list=no
foreign=  # architecture
while [[ $# -gt 0 ]]; do
  case "$1" in
    --library) packages=("${library_packages[@]}"); shift ;;
    --aarch64) packages+=("${aarch64_packages[@]}"); foreign=arm64; shift ;;
    --tests) packages+=("${test_packages[@]}"); shift ;;
    --learners) packages+=("${learner_packages[@]}"); shift ;;
    --wheel) packages+=("${wheel_packages[@]}"); shift ;;
    --clang) packages+=("${clang_packages[@]}"); shift ;;
    --plot) packages+=("${plot_packages[@]}"); shift ;;
    --docs) packages+=("${docs_packages[@]}"); shift ;;
    --slow) packages+=("${slow_packages[@]}"); shift ;;
    --list) list=yes; shift ;;
    -h | --help) usage; exit 0 ;;
    *)
      echo "deploy/install-dependencies.sh: unknown argument '$1'" >&2
      echo "Try: deploy/install-dependencies.sh --help" >&2
      exit 2
      ;;
  esac
done
if [[ $list == yes ]]; then
  printf '%s\n' "${packages[@]}"
  exit 0
fi

if ! command -v dpkg-query >/dev/null; then
  echo "deploy/install-dependencies.sh: this is not Debian; install the equivalents of:" >&2
  printf '  %s\n' "${packages[@]}" >&2
  echo "Continuing as if all were installed." >&2
  exit 0
fi

# Programs that are often installed from other packages, which conflict with Debian's.
declare -A program_of=([kubernetes-client]=kubectl [nodejs]=node)

native=$(dpkg --print-architecture)
missing=()
for package in "${packages[@]}"; do
  program=${program_of[$package]:-}
  if [[ -n $program ]] && command -v "$program" >/dev/null; then
    continue
  fi
  architecture=$native
  [[ $package == *:* ]] && architecture=${package##*:}
  dpkg-query --show --showformat='${Architecture} ${db:Status-Status}\n' "$package" 2>/dev/null |
    grep -qxE "(all|$architecture) installed" || missing+=("$package")
done
if [[ ${#missing[@]} -eq 0 ]]; then
  exit 0
fi

echo "== Installing ${missing[*]}"
as_root=()
if [[ $(id -u) -ne 0 ]]; then
  if ! command -v sudo >/dev/null; then
    echo "deploy/install-dependencies.sh: run it as root, or install sudo" >&2
    exit 1
  fi
  as_root=(sudo)
fi
if [[ -n $foreign ]]; then
  "${as_root[@]}" dpkg --add-architecture "$foreign"
fi
# The package lists may be outdated, or missing on a fresh machine.
"${as_root[@]}" apt-get -o DPkg::Lock::Timeout=120 update --quiet
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get -o DPkg::Lock::Timeout=120 install --yes --quiet --no-install-recommends "${missing[@]}"
