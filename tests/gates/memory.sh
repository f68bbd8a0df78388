#!/usr/bin/env bash
# The readers, the containers of weights, geometry and the estimator under address and
# undefined-behaviour sanitisers. The vector kernels are not instrumented (nn/CMakeLists.txt). What
# takes minutes here is left out where something shorter goes the same ways: the statistics of
# marginalisation and of outliers, and changed bytes, which are the fuzzers' matter.
set -euo pipefail
exec bash "$(dirname "$0")/sanitized_tests.sh" asan-ubsan \
  'nn_(.*_)?(npz|safetensors|tensor|weights|zip)_test' \
  'weights_tools_.*' \
  'weights_tools_hostile_files_test:-*ChangedBytesNeverCrash*' \
  'vo_io_.*' \
  'vo_frontend_(feature_files|match_store)_test' \
  'vo_geometry_.*' \
  'vo_mapping_place_map_test' \
  'vo_geometry_pnp_test:-*AmongOutliersOverWideBaselines*' \
  'vo_estimator_(?!marginalization).*' \
  'vo_pipeline_odometry_test:*Exact*:*Reset*'
