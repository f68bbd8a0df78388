#!/usr/bin/env bash
# What the gates need beyond what the tests install themselves.
set -euo pipefail
cd "$(dirname "$0")/../.."
mapfile -t packages < cmake/packages.txt
bash cmake/install_packages.sh "${packages[@]}" clang-14 clang-format-14 clang-tidy-14 git \
  libbenchmark-dev libclang-rt-14-dev libgtest-dev llvm-14 universal-ctags
