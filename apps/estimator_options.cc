#include "estimator_options.h"

#include <CLI/CLI.hpp>

namespace gluevo::apps {

void AddEstimatorOptions(CLI::App& command, EstimatorOptions& options) {
  const std::string group = "Estimator";
  vo::SlidingWindowOptions& window = options.odometry.window;
  command.add_option("--window", window.size, "Frames of the sliding window")
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--keyframe-parallax", options.keyframe_parallax_px,
                  "A frame is a key frame when its tracks have moved so far since the last one, "
                  "pixels at a focal length of 460")
      ->capture_default_str()
      ->group(group);
  command.add_option("--iterations", window.max_iterations, "Of each bundle adjustment, at most")
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--marginalize", window.marginalize,
                  "Whether frames that leave the window leave what they knew as a prior")
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--right-turn-mrad", options.right_turn_mrad,
                  "How well the calibration knows the right camera's orientation, milliradians; it "
                  "is refined within that; 0: not at all")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str()
      ->group(group);
}

vo::OdometryOptions ResolveEstimatorOptions(const EstimatorOptions& options) {
  vo::OdometryOptions resolved = options.odometry;
  resolved.window.keyframe_parallax = options.keyframe_parallax_px / 460.0;
  resolved.window.right_turn_sigma = 1e-3 * options.right_turn_mrad;
  return resolved;
}

}  // namespace gluevo::apps
