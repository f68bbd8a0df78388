#pragma once

#include "command_line.h"
#include "gluevo/vo/pipeline/odometry.h"

namespace gluevo::apps {

/// The estimator's options in a command line's units.
struct EstimatorOptions {
  vo::OdometryOptions odometry;
  /// At a focal length of 460 pixels, as VINS-Fusion's.
  double keyframe_parallax_px = 460.0 * vo::SlidingWindowOptions().keyframe_parallax;
  double right_turn_mrad = 1e3 * vo::SlidingWindowOptions().right_turn_sigma;
};

void AddEstimatorOptions(CLI::App& command, EstimatorOptions& options);

vo::OdometryOptions ResolveEstimatorOptions(const EstimatorOptions& options);

}  // namespace gluevo::apps
