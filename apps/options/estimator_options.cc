#include "estimator_options.h"

#include "command_line/value_checks.h"
#include "option_group.h"

namespace gluevo::apps {

void AddEstimatorOptions(CLI::App& command, vo::OdometryOptions& options) {
  OptionGroup estimator(command, "Estimator");
  vo::SlidingWindowOptions& window = options.window;
  estimator.Add("--window", window.size, "Frames of the sliding window");
  estimator.Add("--keyframe-parallax", window.keyframe_parallax_px,
                "A frame is a key frame when its tracks have moved so far since the last one, "
                "pixels at a focal length of 460");
  estimator
      .Add("--keyframe-overlap", window.min_keyframe_overlap,
           "... or when the last one sees less than this share of its tracks")
      ->check(Within(0.0, 1.0));
  estimator.Add("--iterations", window.max_iterations, "Of each bundle adjustment, at most");
  estimator
      .Add("--least-decrease", window.least_decrease,
           "An iteration that lowers the cost by less than this share of it is the last")
      ->check(Within(0.0, 1.0));
  estimator
      .Add("--solver", window.solver, "Of the bundle adjustment: gluevo, or ceres to compare with")
      ->check(OneOf({"gluevo", "ceres"}));
  estimator.Add("--marginalize", window.marginalize,
                "Whether frames that leave the window leave what they knew as a prior");
  estimator
      .Add("--right-turn-mrad", window.right_turn_sigma_mrad,
           "How well the calibration knows the right camera's orientation, milliradians; it is "
           "refined within that; 0: not at all")
      ->check(Within(0.0, 1e6));
  estimator
      .Add("--max-predicted", options.max_predicted_s,
           "Where nothing that was seen before is found again, poses are predicted for so many "
           "seconds before a new segment starts")
      ->check(Within(0.0, 1e6));
}

}  // namespace gluevo::apps
