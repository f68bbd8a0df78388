#!/usr/bin/env bash
# The layer nn and its tests for 64-bit Arm: cross-compiled, run under qemu-user. Does everything
# from nothing. The Arm libraries are downloaded into build/arm64-sysroot by an apt with its own
# lists: the system's packages stay as they are.
set -euo pipefail
cd "$(dirname "$0")/.."

bash cmake/install_packages.sh ca-certificates ccache cmake g++-aarch64-linux-gnu ninja-build \
  qemu-user

sysroot=$PWD/build/arm64-sysroot
packages=(libeigen3-dev libgtest-dev googletest libhwy-dev libhwy1 libssl-dev libssl3
          nlohmann-json3-dev zlib1g zlib1g-dev)
if [ "$(cat "$sysroot/packages" 2>/dev/null)" != "${packages[*]}" ]; then
  rm -rf "$sysroot"
  mkdir -p "$sysroot"/apt/{lists/partial,cache/archives/partial}
  touch "$sysroot/apt/status"
  apt=(apt-get -qq -o APT::Architecture=arm64 -o APT::Architectures=arm64
       -o APT::Sandbox::User="$(id -un)" -o Dir::State::Lists="$sysroot/apt/lists"
       -o Dir::State::Status="$sysroot/apt/status" -o Dir::Cache="$sysroot/apt/cache")
  "${apt[@]}" update
  (cd "$sysroot/apt" && "${apt[@]}" download "${packages[@]}")
  for package in "$sysroot"/apt/*.deb; do
    dpkg-deb -x "$package" "$sysroot"
  done
  rm -rf "$sysroot/apt"
  echo "${packages[*]}" > "$sysroot/packages"
fi

cmake --preset arm64 >/dev/null
cmake --build --preset arm64
ctest --preset arm64 -j "$(nproc)" "$@"
