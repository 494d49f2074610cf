# Debian's cross compiler for 64-bit ARM. Packages: crossbuild-essential-arm64, and libabsl-dev and zlib1g-dev of the
# architecture arm64 (dpkg --add-architecture arm64).
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
