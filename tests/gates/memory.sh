#!/usr/bin/env bash
# The readers, the containers of weights, geometry and the estimator under address and
# undefined-behaviour sanitisers. The vector kernels are not instrumented (nn/CMakeLists.txt).
set -euo pipefail
exec bash "$(dirname "$0")/sanitized_tests.sh" asan-ubsan \
  'nn_(.*_)?(npz|safetensors|tensor|weights|zip)_test' \
  'weights_tools_.*' \
  'vo_io_.*' \
  'vo_frontend_(feature_files|match_store)_test' \
  'vo_geometry_.*' \
  'vo_estimator_.*'
