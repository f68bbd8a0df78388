#include "evaluation_text.h"

#include <cmath>

#include "gluevo/vo/core/text.h"

namespace gluevo::apps {
RpeText TextOfRpe(const vo::Evaluation& evaluation, int percent_decimals, int degree_decimals) {
  if (!std::isfinite(evaluation.rpe_translation_percent)) {
    const std::string why = "none: the ground truth moves less than 0.5 m, the shortest length";
    return {why, why, false};
  }
  return {vo::FixedText(evaluation.rpe_translation_percent, percent_decimals) + " %",
          vo::FixedText(evaluation.rpe_rotation_deg_per_m, degree_decimals) + " deg/m", true};
}

std::string TextOfRpeOverFrames(const vo::Evaluation& evaluation, int decimals) {
  if (!std::isfinite(evaluation.rpe_frames_translation_m)) {
    return "none: fewer poses than that associate";
  }
  return vo::FixedText(evaluation.rpe_frames_translation_m, decimals) + " m, " +
         vo::FixedText(evaluation.rpe_frames_rotation_deg, decimals) + " deg";
}

std::string TextOfScale(const vo::Evaluation& evaluation, int decimals) {
  return std::isfinite(evaluation.scale) ? vo::FixedText(evaluation.scale, decimals)
                                         : "none: one of both does not move";
}

}  // namespace gluevo::apps
