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
# A build from nothing is faster with precompiled headers; one that is worked on shows without them
# what a file forgot to include.
from_nothing=()
if [ ! -e build/dev/CMakeCache.txt ]; then
  from_nothing=(-DGLUEVO_PRECOMPILE=ON)
fi
cmake --preset dev "${from_nothing[@]}" -DGLUEVO_CROSSCHECK_PYTHON="$python" >/dev/null
cmake --build --preset dev
GLUEVO_EVO_PYTHON=$python ctest --preset dev --output-on-failure -j "$(nproc)" "$@"
