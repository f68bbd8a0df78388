#!/usr/bin/env bash
# The thread pool and all that runs on it or on threads of its own, under the thread sanitiser: the
# networks with their kernels, the front ends, the pipeline on a few real images where they are
# there, `gluevo live` with its stages and its view, and the renderer.
set -euo pipefail
exec bash "$(dirname "$0")/sanitized_tests.sh" tsan \
  'nn_(.*_)?thread_pool_test' \
  'nn_(.*_)?(keypoint_selection|step_progress)_test' \
  'nn_(.*_)?(superglue|superpoint)_test' \
  'vo_core_bounded_queue_test' \
  'vo_frontend_.*' \
  'vo_pipeline_(live_pipeline|loop_thread|odometry_announce)_test' \
  'vo_pipeline_end_to_end_test:*StandingStill*' \
  'apps_view_view_server_test' \
  'apps_live_test:*OwnPace*:*Signal*:*Beside*' \
  'vo_simulation_.*'
