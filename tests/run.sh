#!/usr/bin/env bash
# All tests: installs what is missing, builds, runs. Tests on real data skip, and say so, where
# ../shared is not there; those against Python's evo and torch where PyPI is not reachable.
set -euo pipefail
cd "$(dirname "$0")/.."

mapfile -t packages < cmake/packages.txt
bash cmake/install_packages.sh "${packages[@]}" chromium clang-format colmap git \
  libbenchmark-dev libgtest-dev python3-h5py
python=$(bash tests/install_python_tools.sh) || python=python3
# What another checkout of the repo has compiled need not be compiled again.
export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1
cmake --preset dev -DGLUEVO_CROSSCHECK_PYTHON="$python" >/dev/null
cmake --build --preset dev
GLUEVO_EVO_PYTHON=$python ctest --preset dev --output-on-failure -j "$(nproc)" "$@"
