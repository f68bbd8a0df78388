#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "gluevo/vo/odometry.h"

namespace gluevo::apps {

/// The estimator's options as a command line gives them; where it is silent the method decides.
struct EstimatorOptions {
  vo::OdometryOptions odometry;
  double keyframe_parallax_px = 10.0;  ///< At a focal length of 460 pixels, as VINS-Fusion's.
  double right_turn_mrad = -1.0;       ///< Negative: by the method.
};

void AddEstimatorOptions(CLI::App& command, EstimatorOptions& options);

/// `method` is the front end's name ("klt", ...).
vo::OdometryOptions ResolveEstimatorOptions(const EstimatorOptions& options,
                                            const std::string& method);

}  // namespace gluevo::apps
