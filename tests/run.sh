#!/usr/bin/env bash
# All tests: installs what is missing, builds, runs. Tests on real data skip, and say so, where
# ../shared is not there.
set -euo pipefail
cd "$(dirname "$0")/.."

mapfile -t packages < cmake/packages.txt
bash cmake/install_packages.sh "${packages[@]}" chromium clang-format colmap git \
  libbenchmark-dev libgtest-dev
# What another checkout of the repo has compiled need not be compiled again.
export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1
cmake --preset dev >/dev/null
cmake --build --preset dev
ctest --preset dev --output-on-failure -j "$(nproc)" "$@"
