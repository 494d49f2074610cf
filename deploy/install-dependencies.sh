#!/usr/bin/env bash
# Installs the Debian packages that building and running need, and testing, where they are missing. See --help.
set -euo pipefail

# What building, packing and the Python client need, and what for. Debian 12 has them all.
packages=(
  g++                     # the compiler
  cmake                   # the build
  ninja-build             # what CMake drives
  pkg-config              # finds libraries that have no CMake package
  libgrpc++-dev           # the server's and the C++ client's transport
  libssl-dev              # reads certificates, hashes tokens
  libprotobuf-dev         # messages
  protobuf-compiler       # generates messages
  protobuf-compiler-grpc  # generates service stubs, C++ and Python
  libabsl-dev             # status, strings, containers, synchronisation
  libspdlog-dev           # log lines
  libzstd-dev             # compresses observations
  libsqlite3-dev          # a fleet keeps its pools in databases
  prometheus-cpp-dev      # metrics
  cyclonedds-dev          # servers of a cluster find each other
  cyclonedds-tools        # compiles what they say to each other
  libboost-dev            # HTTP and WebSocket for the pages
  libpng-dev              # art and pictures
  librsvg2-bin            # rasterises the art while building
  nlohmann-json3-dev      # recordings and what pages are told are JSON
  zlib1g-dev              # and compressed
  pybind11-dev            # the C++ client as a module of Python
  python3                 # the Python client, the quickstart, some tests
  python3-dev             # headers of that module
  python3-grpcio          # the Python client's transport
  python3-protobuf        # its messages
  python3-numpy           # its arrays
  python3-pil             # the picture that the quickstart draws
  dpkg-dev                # what a Debian package depends on
  file                    # what is a program in it
  fonts-dejavu-core       # the names in that picture
)

# What the tests need besides: those of the other clients, a browser, tools that check.
test_packages=(
  git                     # lists the files that the tidy test looks at
  libgtest-dev            # tests
  libgmock-dev            # matchers of the tests
  libcpp-httplib-dev      # their HTTP client
  libbenchmark-dev        # benchmarks
  openssl                 # makes the certificates of the tests
  python3-pytest          # the Python client's tests
  python3-websockets      # pages, as tests are them
  python3-pip             # a wheel of it
  python3-wheel           # the wheel's format
  python3-setuptools      # what builds it
  mypy                    # checks its types
  ffmpeg                  # its videos
  nodejs                  # the Node.js client and its tests; what else it needs npm fetches
  chromium                # the browser that the tests open the server's pages in
  golang-go               # the Go client and its tests
  protoc-gen-go           # its messages
  protoc-gen-go-grpc      # its service stubs
  golang-google-grpc-dev  # its transport
  golang-google-protobuf-dev  # its messages' library
  golang-github-klauspost-compress-dev  # decompresses its observations
  python3-yaml            # the tests of deploy/ read manifests
  kubernetes-client       # and render those of Kubernetes
  iproute2                # networks of tests' own
  nftables                # and what cuts hosts off from them
)

# What clients/python/learners needs. The tests need it as well.
learner_packages=(
  python3-torch           # networks, on the CPU
  libopenblas0-pthread    # its linear algebra; the reference BLAS takes 20 times as long
)
test_packages+=("${learner_packages[@]}")

# npm comes with some packages of nodejs, and Debian's would not go along with those.
command -v npm >/dev/null || test_packages+=(npm)

# What the presets lint and fuzz need besides.
clang_packages=(
  clang                   # the compiler of both presets
  clang-tidy              # the linter
  libclang-rt-14-dev      # libFuzzer and the sanitizers of that compiler
)

# What tests/benchmark/stream_report.py draws with.
plot_packages=(
  python3-matplotlib
)

# What tests of the label slow build and run images with, and check rules for Prometheus.
slow_packages=(
  mmdebstrap              # makes a root of Debian without asking a registry of images
  buildah                 # builds images
  podman                  # runs them
  runc                    # by this, which also knows older control groups
  prometheus              # promtool
  nginx                   # the front of deploy/front
)

usage() {
  cat <<TEXT
Usage: deploy/install-dependencies.sh [--tests] [--clang] [--plot] [--slow] [--list] [--help]

Installs with apt what is missing of the packages that building Procgen Server and its Python client need. Asks apt for
nothing if nothing is missing. Needs root or sudo otherwise.

  --tests  and what the tests need, those of the clients in Node.js and Go as well
  --learners  and what clients/python/learners needs, PyTorch above all (with the tests' packages, too)
  --clang  and what the presets lint and fuzz need
  --plot   and what draws the picture of the stream's benchmark
  --slow   and what the tests of the label slow need
  --list   print the names of the packages and stop
  --help   print this and stop
TEXT
}

list=no
while [[ $# -gt 0 ]]; do
  case "$1" in
    --tests) packages+=("${test_packages[@]}"); shift ;;
    --learners) packages+=("${learner_packages[@]}"); shift ;;
    --clang) packages+=("${clang_packages[@]}"); shift ;;
    --plot) packages+=("${plot_packages[@]}"); shift ;;
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
  echo "deploy/install-dependencies.sh: this is not Debian; install what corresponds to:" >&2
  printf '  %s\n' "${packages[@]}" >&2
  echo "Going on as if all were there." >&2
  exit 0
fi

# Programs that machines often have by other packages, which Debian's would clash with.
declare -A program_of=([kubernetes-client]=kubectl [nodejs]=node)

missing=()
for package in "${packages[@]}"; do
  program=${program_of[$package]:-}
  if [[ -n $program ]] && command -v "$program" >/dev/null; then
    continue
  fi
  state=$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null || true)
  [[ $state == installed ]] || missing+=("$package")
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
# The lists of packages may be old, or missing altogether on a fresh machine.
"${as_root[@]}" apt-get -o DPkg::Lock::Timeout=120 update --quiet
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get -o DPkg::Lock::Timeout=120 install --yes --quiet --no-install-recommends "${missing[@]}"
